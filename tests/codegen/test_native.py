"""Compiled frames against the interpreter, bit by bit; and what happens without a compiler, a cache or room."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import saoflow
from saoflow import cache
from saoflow.codegen import compiler, native, objects
from saoflow.codegen.compiler import find_compiler
from saoflow.codegen.native import NativeSimulator
from saoflow.diagnosis import DiagnosisError
from saoflow.pipeline import LoadedSheet
from tests.sheet_text import same_bits, sheet_of
from verification.flights import Fault, load_recording, sensors

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler on this machine")

SMALL = """
    sheet: small
    inputs: {u: {}, v: {shape: [2]}, on: {type: boolean}}
    blocks:
      before: {delay: total, initial: 0.25}
      scaled: {mul: [u, 0.1]}
      total:  {add: [scaled, before]}
      look:   {lookup: v, breakpoints: [-1, 0, 2], values: [3, -0.5, 1]}
      less:   {compare: [u, before], relation: '<'}
      both:   {and: [less, on]}
      out:    {switch: [both, total, u]}
      seen:   {delay: both, initial: 0}
    outputs: [total, look, out, both, seen]
    """


@pytest.fixture(scope="module", autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Objects of these tests go to a folder of their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


def small_inputs(*lead: int) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(5)
    u = rng.normal(size=lead)
    odd = [np.nan, np.inf, -np.inf, 5e-324, -0.0, 1e300, 1e-310]
    u.flat[3 : 3 + len(odd)] = odd[: max(0, u.size - 3)]
    return {"u": u, "v": rng.normal(size=(*lead, 2)), "on": rng.random(lead) < 0.7}


def flagship_inputs(frames: int) -> dict[str, np.ndarray]:
    """A flight with noise, a fault, missing samples, and odd numbers."""
    recording = load_recording("a320_wind_350kt_5000ft")
    fault = Fault("runaway", "vc", which=(1, 2), rate=-15.0, onset=20.0)
    inputs = {
        k: np.array(v[:frames], dtype=float) for k, v in sensors(recording, seed=4, faults=[fault]).inputs().items()
    }
    rng = np.random.default_rng(8)
    for name in ("alpha", "vc", "vg", "q", "z"):
        hit = rng.random(inputs[name].shape) < 0.02
        inputs[name][hit] = rng.choice([np.nan, np.inf, -np.inf, 0.0, -0.0, 5e-324, -1e-310, 1e308], hit.sum())
    return inputs


def assert_same(found: dict[str, np.ndarray], expected: dict[str, np.ndarray]) -> None:
    assert list(found) == list(expected)
    for name, array in expected.items():
        assert same_bits(found[name], array), name


@pytest.mark.parametrize("real", [64, 32])
def test_flagship_has_the_bits_of_the_interpreter(real: int) -> None:
    sheet = saoflow.load("cmhe_fte")
    inputs = flagship_inputs(1500 if real == 64 else 100)  # the interpreter is slow in binary32
    slow, fast = sheet.simulator(real=real), sheet.simulator(backend="c", real=real)
    expected = slow.run(inputs)
    assert expected["vc_faulty"].any() == (real == 64) and not np.isnan(expected["vc_hat"]).any()
    assert_same(fast.run(inputs), expected)
    assert same_bits(fast.state().slots, slow.state().slots)


@pytest.mark.parametrize("real", [64, 32])
def test_lanes_have_the_bits_of_single_flights(real: int) -> None:
    sheet = saoflow.load("cmhe_fte")
    one = flagship_inputs(1500)
    flights = 21  # no multiple of a register's lanes
    batch = {name: np.stack([np.roll(a, 37 * f, axis=0)[:100] for f in range(flights)]) for name, a in one.items()}
    simulator = sheet.simulator(backend="c", real=real)
    found = simulator.run(batch)
    state = simulator.state().slots
    for f in range(flights):
        single = sheet.simulator(backend="c", real=real)
        expected = single.run({name: a[f] for name, a in batch.items()})
        assert_same({name: a[f] for name, a in found.items()}, expected)
        assert same_bits(np.ascontiguousarray(state[:, f]), single.state().slots)


@pytest.mark.parametrize("real", [64, 32])
def test_batches_have_the_bits_and_types_of_the_interpreter(tmp_path: Path, real: int) -> None:
    sheet = sheet_of(tmp_path, SMALL)
    inputs = small_inputs(9, 50)
    slow, fast = sheet.simulator(real=real), sheet.simulator(backend="c", real=real)
    for _ in range(2):
        assert_same(fast.run(inputs), slow.run(inputs))
        assert same_bits(fast.state().slots, slow.state().slots)


def test_state_goes_from_the_interpreter_to_c_and_back(tmp_path: Path) -> None:
    sheet = sheet_of(tmp_path, SMALL)
    inputs = small_inputs(60)
    slow, fast = sheet.simulator(), sheet.simulator(backend="c")
    whole = slow.run(inputs)
    first, second = ({k: v[part] for k, v in inputs.items()} for part in (slice(0, 25), slice(25, 60)))
    slow.reset()
    slow.run(first)
    fast.restore(slow.state())
    assert fast.state().frame == 25
    found = fast.run(second)
    assert_same(found, {k: v[25:] for k, v in whole.items()})
    fast.reset()
    stepped = [fast.step({k: v[i] for k, v in inputs.items()}) for i in range(10)]
    for name, array in whole.items():
        assert same_bits(np.stack([s[name] for s in stepped]), array[:10])


def test_arrays_need_not_lie_in_one_piece(tmp_path: Path) -> None:
    sheet = sheet_of(tmp_path, SMALL)
    inputs = small_inputs(5, 40)
    simulator = sheet.simulator(backend="c")
    shared = {k: np.broadcast_to(v[0], v.shape) for k, v in inputs.items()}
    found = simulator.run(shared)
    simulator.reset()
    assert_same(found, simulator.run({k: v.copy() for k, v in shared.items()}))
    simulator.reset()
    backwards = {k: np.asarray(v, dtype=float)[:, ::-2] for k, v in inputs.items()}
    found = simulator.run(backwards)
    simulator.reset()
    assert_same(found, simulator.run({k: v.copy() for k, v in backwards.items()}))


def test_one_flight_and_a_batch_do_not_mix(tmp_path: Path) -> None:
    for real in (64, 32):
        simulator = sheet_of(tmp_path, SMALL).simulator(backend="c", real=real)
        simulator.run(small_inputs(20))
        with pytest.raises(DiagnosisError, match="E508"):
            simulator.run(small_inputs(2, 20))


def test_probes_and_parameters_are_part_of_what_is_cached(tmp_path: Path) -> None:
    text = (
        "sheet: p\nparameters: {g: 2}\ninputs: {u: {}}\nblocks:\n  a: {mul: [u, g]}\n  b: {mul: [a, a]}\noutputs: [b]\n"
    )
    found = []
    for g in (2, 3, 2):
        simulator = sheet_of(tmp_path, text, g=g).simulator(backend="c", probes=["a"])
        found.append(float(simulator.run({"u": [1.0]})["a"][0]))
    assert found == [2.0, 3.0, 2.0]
    changed = sheet_of(tmp_path, text.replace("mul: [a, a]", "mul: [a, a, a]"))
    assert changed.simulator(backend="c").run({"u": [1.0]})["b"][0] == 8.0


def test_a_sub_sheet_that_changes_is_compiled_anew(tmp_path: Path) -> None:
    below = "sheet: below\ninputs: [u]\nblocks:\n  y: {mul: [u, %s]}\noutputs: [y]\n"
    text = "sheet: above\ninputs: {u: {}}\nblocks:\n  y: {below: [u]}\noutputs: {y: y.y}\n"
    for factor in ("2", "5"):
        (tmp_path / "below.yaml").write_text(below % factor, encoding="utf-8")
        assert sheet_of(tmp_path, text).simulator(backend="c").run({"u": [1.0]})["y"][0] == float(factor)


def cached_once(tmp_path: Path, patch: pytest.MonkeyPatch) -> tuple[LoadedSheet, Path]:
    """A sheet with its object in a folder of its own, and that folder."""
    patch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    sheet = sheet_of(tmp_path, SMALL)
    sheet.simulator(backend="c").run(small_inputs(3))
    return sheet, tmp_path / "cache" / "saoflow"


def test_nothing_is_compiled_or_elaborated_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cached_once(tmp_path, monkeypatch)
    again = saoflow.load(str(tmp_path / "sheet.yaml"))
    monkeypatch.setattr(objects, "compiled", lambda *_: pytest.fail("compiled again"))
    assert isinstance(again.simulator(backend="c"), NativeSimulator)
    assert "netlist" not in vars(again)


def test_damaged_objects_are_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sheet, folder = cached_once(tmp_path, monkeypatch)
    expected = sheet.simulator().run(small_inputs(3))
    for damage in (lambda data: data[: len(data) // 2], lambda data: b"", lambda data: data[:-200] + bytes(200)):
        for path in folder.iterdir():
            # A new file, as this process has the old one mapped.
            content = path.read_bytes()
            path.unlink()
            path.write_bytes(damage(content))
        assert_same(sheet.simulator(backend="c").run(small_inputs(3)), expected)


def test_no_part_is_left_behind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    _, folder = cached_once(tmp_path, monkeypatch)
    assert not [p for p in folder.iterdir() if p.name.startswith("part-")]
    old = folder / "part-killed"
    old.mkdir()
    os.utime(old, (0, 0))
    cache.Folder(folder).tidy()
    assert not old.exists()


def test_concurrent_processes_share_a_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    sheet_of(tmp_path, SMALL)
    script = (
        "import saoflow; s = saoflow.load('sheet.yaml').simulator(backend='c');"
        "print(s.run({'u': [1.0], 'v': [[0.5, 1]], 'on': [1]})['total'][0])"
    )
    runs = [
        subprocess.Popen([sys.executable, "-c", script], cwd=tmp_path, stdout=subprocess.PIPE, text=True)
        for _ in range(3)
    ]
    assert [run.communicate()[0].strip() for run in runs] == ["0.35"] * 3


def test_without_a_compiler_the_interpreter_runs_and_says_so_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(compiler.importlib.util, "find_spec", lambda name: None)
    objects.warn_once.cache_clear()
    sheet = sheet_of(tmp_path, SMALL)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        first, second = sheet.simulator(backend="c"), sheet.simulator(backend="c")
    assert not isinstance(first, NativeSimulator) and not isinstance(second, NativeSimulator)
    assert [str(w.message).split(":")[0] for w in caught] == ["warning[W607]"]
    assert_same(first.run(small_inputs(5)), sheet.simulator().run(small_inputs(5)))


def test_a_compiler_that_fails_is_diagnosed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken = tmp_path / "broken"
    broken.write_text("#!/bin/sh\n[ $1 = --version ] && exit 0\necho 'frame.c:1: no such luck' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("SAOFLOW_CC", str(broken))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(DiagnosisError) as caught:
        sheet_of(tmp_path, SMALL).simulator(backend="c")
    (found,) = caught.value.diagnoses
    assert found.code == "E607" and found.cause == "frame.c:1: no such luck" and str(broken) in found.message
    assert not [p for p in (tmp_path / "cache/saoflow").iterdir() if p.suffix == ".so" or p.name.startswith("part-")]


@pytest.mark.parametrize(
    ("named", "cause"),
    [
        ("nowhere_cc", "there is no program `nowhere_cc`"),
        ("BENCH -x", "asked for its version (--version), it ends with exit code 1"),
        ('gcc "', "it cannot be split into words: No closing quotation"),
        ("BENCH silent", "it ends without an error, but it has written nothing"),
        ("BENCH junk", "what it has written is no shared library"),
        ("BENCH cross", "it makes code for another machine"),
    ],
)
def test_a_compiler_that_is_named_is_used_or_refused(
    named: str, cause: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = tmp_path / "bench"
    script.write_text(
        "#!/bin/sh\nfor last; do :; done\n[ $2 = --version ] && [ $1 != -x ] && exit 0\n"
        "case $1 in junk) echo junk > $last;; cross) printf '\\177ELF\\002\\002\\001.............' > $last;; silent) ;; *) exit 1;; esac\n"
    )
    script.chmod(0o755)
    monkeypatch.setenv("SAOFLOW_CC", named.replace("BENCH", str(script)))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(DiagnosisError) as caught:
        sheet_of(tmp_path, SMALL).simulator(backend="c")
    (found,) = caught.value.diagnoses
    assert found.code == "E607" and found.cause == cause


def test_a_disk_that_is_full_for_the_linker_is_no_fault_of_the_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    linker = tmp_path / "linker"
    linker.write_text(
        "#!/bin/sh\n[ $1 = --version ] && exit 0\necho 'ld: final link failed: No space left on device' >&2\nexit 1\n"
    )
    linker.chmod(0o755)
    monkeypatch.setenv("SAOFLOW_CC", str(linker))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with pytest.raises(DiagnosisError) as caught:
        sheet_of(tmp_path, SMALL).simulator(backend="c")
    assert str(tmp_path / "cache") in caught.value.diagnoses[0].cause
    assert caught.value.diagnoses[0].remedy.startswith("make room there")


def test_a_full_disk_is_diagnosed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    objects.warn_once.cache_clear()

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(cache.Folder, "write", full)
    with warnings.catch_warnings(), pytest.raises(DiagnosisError, match="No space left on device") as caught:
        warnings.simplefilter("ignore")
        sheet_of(tmp_path, SMALL).simulator(backend="c")
    assert caught.value.diagnoses[0].code == "E607"


@pytest.mark.parametrize("how", ["a file in the way", "others may write"])
def test_a_cache_that_cannot_be_used_is_replaced_and_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: str
) -> None:
    base = tmp_path / "cache"
    monkeypatch.setenv("XDG_CACHE_HOME", str(base))
    objects.warn_once.cache_clear()
    if how == "a file in the way":
        base.write_text("")
    else:
        (base / "saoflow").mkdir(parents=True)
        (base / "saoflow").chmod(stat.S_IRWXU | stat.S_IRWXG | stat.S_IRWXO)
    sheet = sheet_of(tmp_path, SMALL)
    with pytest.warns(objects.BackendWarning, match="compiled code is not kept"):
        simulator = sheet.simulator(backend="c")
    assert_same(simulator.run(small_inputs(5)), sheet.simulator().run(small_inputs(5)))


def test_exact_mode_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DiagnosisError, match="E607"):
        sheet_of(tmp_path, SMALL).simulator(backend="c", exact=True)


def test_a_large_frame_gets_a_stack_of_its_own_and_a_huge_one_a_diagnosis(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sheet = sheet_of(tmp_path, SMALL)
    expected = sheet.simulator().run(small_inputs(30))
    monkeypatch.setattr(native, "SMALL_STACK", 100)
    assert_same(sheet.simulator(backend="c").run(small_inputs(30)), expected)
    monkeypatch.setattr(native, "MOST_STACK", 200)
    with pytest.raises(DiagnosisError, match=r"E610.*200 allowed"):
        sheet.simulator(backend="c")
