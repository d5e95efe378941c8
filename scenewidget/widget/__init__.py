"""The notebook widgets: a thin skin over the engine and over `scenewidget.editing`.

`SceneWidget` and `Compare` are what people put into a cell; they join the parts:

==================  =============================================================================
``scene_view``      the picture, and the segments that it shows
``scene_state``     what Python and the page share about it: the list of traits
``wire``            how arrays and messages cross between the picture and the browser
``segment_colors``  which colour a segment has, and how it lasts over edits
``edit_commands``   what a person does in the picture goes to the `Session`, and back into the picture
``suggestion_bar``  suggestions, one at a time
``autosave``        when the project file begins, and what is told of it
``controls``        the settings; ``settings`` says what there is to set
``previewer``       coarse results while a slider moves
``scores``          comparison with a truth
``workbench``       a queue of scans above the widget, for several people
``worker``          computing off the main thread
==================  =============================================================================

From a drag in the picture to the row in the project file:

1. ``js/src/input`` turns the drag into a command, shows the edit at once, and sends it as a message such as
   ``{"kind": "merge", "face": 12, "onto_face": 40, …}`` (`scenewidget.widget.wire` lists them all).
2. `SceneWidget` hands the message to `EditCommands.handle`, which calls `Session.merge`.
3. `Session.do` asks its `History`, which changes the `Partition`: segments over atoms, a few entries each.
4. `ProjectBinding.append` brings the operation to `ProjectFile.append`, and `scenewidget.editing.schema`
   writes it as a row. Only then does the call return.
5. The session tells its observers. `EditCommands` shows the new snapshot (`SceneView.show_snapshot`) and
   answers the message, and the browser lets go of its own guess.
"""
