"""Order, loops, folds, procedures, probes and state, each against a hand-written recursion."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import networkx as nx
import numpy as np
import pytest

from saoflow import DiagnosisError
from saoflow.scheduler.validate import validate_program, validate_schedule
from tests.sheet_text import run, same_bits, sheet_of


def write(folder: Path, name: str, text: str) -> None:
    (folder / f"{name}.yaml").write_text(text, encoding="utf-8")


def test_a_delay_inside_a_sub_sheet_breaks_a_loop_through_it(tmp_path: Path) -> None:
    write(tmp_path, "hold", "sheet: hold\ninputs: [u]\nblocks: {y: {delay: u, initial: 1}}\noutputs: [y]\n")
    sheet = sheet_of(
        tmp_path,
        """
        sheet: s
        inputs: [u]
        blocks:
          next: {add: [u, back]}
          back: {hold: next}
        outputs: [next]
        """,
    )
    assert np.array_equal(run(sheet, u=[1.0, 1.0, 1.0])["next"], [2.0, 3.0, 4.0])


def test_a_loop_that_only_seems_to_be_one_is_no_loop(tmp_path: Path) -> None:
    """Two independent paths through one stateless sub-sheet, one feeding the other."""
    write(
        tmp_path,
        "pair",
        "sheet: pair\ninputs: [a, b]\nblocks: {x: {mul: [a, 2]}, y: {add: [b, 1]}}\noutputs: [x, y]\n",
    )
    sheet = sheet_of(
        tmp_path,
        """
        sheet: s
        inputs: [u]
        blocks:
          p: {pair: {a: u, b: p.x}}
          q: {pair: {a: p.y, b: q.x}}
        outputs: {y: q.y}
        """,
    )
    assert np.array_equal(run(sheet, u=[3.0])["y"], [15.0])


def test_an_algebraic_loop_is_walked_wire_by_wire(tmp_path: Path) -> None:
    with pytest.raises(DiagnosisError) as caught:
        sheet_of(
            tmp_path,
            """
            sheet: s
            inputs: [u]
            blocks:
              a: {add: [u, c]}
              b: {mul: [a, 2]}
              c: {mul: [b, 3]}
            outputs: [c]
            """,
        ).check()
    (found,) = caught.value.diagnoses
    assert found.code == "E301"
    assert [note.text for note in found.notes] == ["a -> b", "b -> c", "c -> a"]
    assert [note.position.line for note in found.notes if note.position] == [6, 7, 5]


FOLD = """
sheet: lag
parameters: {gain: 0.5}
inputs: {x: {}, u: {}}
blocks:
  e: {add: [u, -x]}
  k1: {mul: [e, gain]}
  k2: {mul: [k1, k1]}
  k3: {add: [k2, e, k1]}
  k4: {mul: [k3, k3, e]}
  k5: {add: [k4, k3]}
  k6: {saturation: k5, low: -10, high: 10}
  x_next: {add: [x, k6]}
outputs: {x: x_next, seen: k6}
"""


def lag(x: float, u: float) -> tuple[float, float]:
    e = u - x
    k1 = e * 0.5
    k3 = (k1 * k1 + e) + k1
    k5 = (k3 * k3) * e + k3
    k6 = min(max(k5, -10.0), 10.0)
    return x + k6, k6


def test_fold_forward_and_reverse_with_probes_into_procedures(tmp_path: Path) -> None:
    write(tmp_path, "lag", FOLD)
    text = """
        sheet: s
        inputs: {u: {shape: [4]}, x0: {}}
        blocks:
          forward: {fold: lag, count: 4, carry: {x: x0}, each: {u: u}}
          backward: {fold: lag, count: 4, order: reverse, carry: {x: "forward.x[-1]"}, each: {u: forward.seen}}
        outputs: {f: forward.x, b: backward.x, s: "backward.seen[1:3]"}
        """
    sheet = sheet_of(tmp_path, text)
    rng = np.random.default_rng(4)
    u, x0 = rng.normal(size=(20, 4)), rng.normal(size=20)
    out = run(sheet, u=u, x0=x0)
    for k in range(20):
        x, seen, forward = x0[k], [], []
        for i in range(4):
            x, s = lag(x, u[k, i])
            forward.append(x)
            seen.append(s)
        assert same_bits(out["f"][k], np.array(forward))
        backward = [0.0] * 4
        again = [0.0] * 4
        for i in (3, 2, 1, 0):
            x, again[i] = lag(x, seen[i])
            backward[i] = x
        assert same_bits(out["b"][k], np.array(backward))
        assert same_bits(out["s"][k], np.array(again[1:3]))
    assert len(sheet.frame_program.procedures) == 1
    probed = sheet.simulator(probes=["backward[2].k6", "forward[0].e"]).run({"u": u, "x0": x0})
    assert same_bits(probed["f"], out["f"]) and same_bits(probed["b"], out["b"])
    assert same_bits(probed["forward[0].e"], u[:, 0] - x0)
    assert same_bits(probed["backward[2].k6"], out["s"][:, 1])


def test_map_gives_each_instance_its_slice_and_its_index(tmp_path: Path) -> None:
    write(
        tmp_path,
        "scaled",
        "sheet: scaled\nparameters: {n: {}}\ninputs: {u: {}, g: {}}\nblocks: {y: {mul: [u, g, n + 1]}}\noutputs: [y]\n",
    )
    sheet = sheet_of(
        tmp_path,
        """
        sheet: s
        inputs: {u: {shape: [3]}, g: {}}
        blocks:
          all: {map: scaled, count: 3, each: {u: u}, in: {g: g}, n: index}
        outputs: [all]
        """,
    )
    assert np.array_equal(run(sheet, u=[[1, 2, 3]], g=[10.0])["all"], [[10.0, 40.0, 90.0]])


def test_state_can_be_taken_out_and_put_back(tmp_path: Path) -> None:
    sheet = sheet_of(
        tmp_path,
        """
        sheet: s
        inputs: {u: {shape: [2]}}
        blocks:
          x: {delay: next, shape: [2], frames: 2, initial: 1}
          half: {mul: [x, 0.5]}
          next: {add: [half, u]}
        outputs: [next]
        """,
    )
    u = np.random.default_rng(5).normal(size=(30, 2))
    whole = sheet.simulator().run({"u": u})["next"]
    first = sheet.simulator()
    head = first.run({"u": u[:11]})["next"]
    second = sheet.simulator()
    second.restore(first.state())
    assert same_bits(np.vstack([head, second.run({"u": u[11:]})["next"]]), whole)
    steps = sheet.simulator()
    assert same_bits(np.array([steps.step({"u": row})["next"] for row in u]), whole)
    batch = sheet.simulator()
    flights = np.stack([u, 2 * u])
    parts = [batch.run({"u": flights[:, :7]})["next"], batch.run({"u": flights[:, 7:]})["next"]]
    assert same_bits(np.concatenate(parts, axis=1)[0], whole)
    with pytest.raises(DiagnosisError, match="E508"):
        batch.run({"u": flights[:1]})


def test_the_validators_notice_a_wrong_order(tmp_path: Path) -> None:
    sheet = sheet_of(tmp_path, "sheet: s\ninputs: [u]\nblocks: {a: {mul: [u, 2]}, b: {mul: [a, u]}}\noutputs: [b]\n")
    good = sheet.schedule
    for order in (tuple(reversed(good.order)), good.order[:-1], (*good.order, good.order[0])):
        with pytest.raises(DiagnosisError, match="E302"):
            validate_schedule(replace(good, order=order))
    program = sheet.frame_program
    (group,) = program.groups
    swapped = replace(group, body=replace(group.body, operations=group.body.operations[::-1]))
    with pytest.raises(DiagnosisError, match="E302"):
        validate_program(replace(program, groups=(swapped,)))


def test_a_frame_over_budget_is_refused_before_it_runs(tmp_path: Path) -> None:
    text = """
        sheet: s
        inputs: [u]
        blocks:
          a: {mul: [u, u]}
          b: {add: [a, u]}
        outputs: [b]
        budget: {operations: 1, multiply: 1, period: 0.048}
        """
    sheet = sheet_of(tmp_path, text)
    report = sheet.budget()
    assert (report.total, report.over, report.period) == (2, True, 0.048)
    with pytest.raises(DiagnosisError, match="E401") as caught:
        sheet.simulator()
    assert "2 operations, 1 allowed" in str(caught.value)
    sheet_of(tmp_path, text.replace("operations: 1", "operations: 2")).simulator()


def test_the_netlist_is_a_graph_of_every_symbol_of_every_instance(tmp_path: Path) -> None:
    write(tmp_path, "lag", FOLD)
    sheet = sheet_of(
        tmp_path,
        """
        sheet: s
        inputs: {u: {shape: [2]}}
        blocks:
          all: {fold: lag, count: 2, carry: {x: before}, each: {u: u}}
          before: {delay: "all.x[-1]", initial: 0}
        outputs: {y: "all.x[-1]"}
        """,
    )
    graph = sheet.graph()
    assert {f"all[{i}].{name}" for i in (0, 1) for name in ("e", "k1", "k6", "x_next")} <= set(graph)
    assert graph.nodes["all[1].k2"]["symbol"] == "mul"
    assert graph.has_edge("all[0].x_next", "all[1].e") and graph.has_edge("before", "all[0].e")
    assert graph.has_edge("all[1].x_next", "before") and graph.has_edge("all[1].x_next", "output y")
    assert not nx.is_directed_acyclic_graph(graph)
    within_the_frame = nx.DiGraph((a, b) for a, b, edge in graph.edges(data=True) if edge["feeds_through"])
    assert nx.is_directed_acyclic_graph(within_the_frame)
