"""Many scans: a whole dataset segmented by one call, resumed, judged, and looked through afterwards.

============  ==============================================================================
``runs``      `segment_all` and its `Run`
``schedule``  in which order, and what becomes of those whose process died
``pools``     who does it: this process, workers of our own, or any Dask cluster
``plan``      what is to be done with one scan
``job``       one scan, from its file to its results
``rows``      what is known of a scan afterwards, on disk as ``row.json``
``places``    folders of this machine and of stores
``clients``   of Dask clusters, whoever's they are
``claims``    one run at a time into a folder
``folders``   labels in folders, and the scans that they are of
``memory``    how much a scan takes, expected and measured
``picture``   a small picture of a segmented scan
``progress``  how far a run is, for people
``worklist``  what people have done with the results
``tiles``     a scan that is too large to be segmented whole
``dataset``   all of it in the layout of ScanNet, with a split and statistics
============  ==============================================================================
"""
