"""The table of steps: in order, with titles, and with keys that tell apart what gives another result."""

import pytest

from scenewidget.engine.params import Params
from scenewidget.engine.stages import TITLES, stages

VARIANTS = [
    Params(),
    Params.thesis(),
    Params(feature="gps"),
    Params(consensus="median"),
    Params(n_segments="auto", granularity=5),
    Params(consensus="peac", granularity=5),
    Params(n_runs=0),
    Params(n_graph_runs=0),
    Params(allocation="raw"),
]


@pytest.mark.parametrize("params", VARIANTS)
def test_each_step_needs_only_those_above_it_and_the_last_needs_them_all(params):
    table = stages(params)
    above = ["mesh", "members"]
    for name, stage in table.items():
        assert set(stage.needs) <= set(above)
        assert (stage.name, stage.title) == (name, TITLES[name])
        assert not stage.recalls or stage.recalls in stage.needs
        above.append(name)
    wanted, asked = set(), [name]
    while asked:
        wanted.add(step := asked.pop())
        asked += [need for need in table[step].needs if need not in ("mesh", "members")]
    assert wanted == set(table)


def test_every_title_is_used_and_in_the_order_of_the_table():
    assert set().union(*(stages(params) for params in VARIANTS)) == set(TITLES)
    order = list(TITLES)
    for params in VARIANTS:
        places = [order.index(name) for name in stages(params)]
        late = stages(params).get("tree") is not None and params.consensus != "linkage"
        assert late or places == sorted(places)


def test_a_step_has_the_same_key_exactly_where_it_gives_the_same_result():
    plain, other = stages(Params()), stages(Params(min_area=0.5))
    changed = {name for name in plain if plain[name].key != other[name].key}
    assert changed == {"finish", "segmentation"}
    keys = {stages(Params(consensus=c, n_segments=9))["consensus"].key for c in ("linkage", "median", "peac")}
    assert len(keys) == 3
    assert stages(Params())["items"].key != stages(Params(items="simplified"))["items"].key
    hash(tuple(stage.key for stage in plain.values()))


def test_a_step_can_be_asked_for_that_nothing_needs():
    table = stages(Params(n_eigenpairs=7), also="eigenbasis")
    assert set(table) - set(stages(Params())) == {"eigenbasis"}
    assert dict(table["eigenbasis"].options)["k"] == 7
    assert list(stages(Params.thesis(), also="eigenbasis"))[-1] == "segmentation"
