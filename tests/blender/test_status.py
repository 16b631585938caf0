# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render says of itself while it runs: the progress log and the status line, with a stand-in core."""
import json

import bpy
from stand_ins import Engine, job_of_engine


def test_progress_log(fake_core, monkeypatch, tmp_path):
    from sluice import final
    monkeypatch.setenv("SLUICE_PROGRESS_LOG", str(tmp_path / "log.jsonl"))
    engine = Engine()
    engine.job = job_of_engine()
    engine.job.settings.update(passes=5, photons=5 * 10**6)  # 0.05 s a pass
    engine.job.warnings = [("Lamp", "is off")]
    final.render(engine)
    rows = [json.loads(line) for line in (tmp_path / "log.jsonl").read_text().splitlines()]
    assert len(rows) >= 2 and all(row["effects"] == [["direct", True, "there is a light"]] for row in rows)
    assert [row["pass"] for row in rows] == sorted({row["pass"] for row in rows})
    assert rows[-1]["pass"] == 5 and rows[-1]["stop_reason"] == 'passes' and rows[-1]["warnings"] == [["Lamp", "is off"]]
    assert "statistics" in rows[-1] and "statistics" not in rows[0]


def test_progress_log_of_an_animation(edited_scene, fake_core, monkeypatch, tmp_path):
    """Of every frame; a new process begins the file anew."""
    path = tmp_path / "log.jsonl"
    path.write_text("of a process before\n")
    monkeypatch.setenv("SLUICE_PROGRESS_LOG", str(path))
    edited_scene.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(animation=True)
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    assert [row["frame"] for row in rows if "statistics" in row] == [1, 2]
    assert {row["view_layer"] for row in rows} == {bpy.context.view_layer.name}


def test_status_lines():
    from sluice import render_progress
    progress = {"state": 'rendering', "pass": 3, "passes": 64, "photons": 3145678, "seconds": 72, "seconds_left": 3723.4,
                "error_estimate": 0.0521, "noise": 0.05, "bias": 0.0146, "main_cause": ("Caustics", 0.614), "passes_to_target": None,
                "stop_reason": 'passes', "message": ""}
    assert render_progress.line(progress) == ("Pass 3/64 | Photons 3.1 M | Error 5.2 % (noise 5 %, blur 1.5 %) | Time 1:12 | Left 1:02:03 | "
                                              "most of the error: Caustics, 61 %")
    assert "blur 1.5 %; without Sun: not met) |" in render_progress.line({**progress, "unmet": ["Sun"]})
    assert "blur 1.5 %; without Sun, World …: not met) |" in render_progress.line({**progress, "unmet": ["Sun", "World", "Dome"]})
    unknown = {**progress, "seconds_left": None, "error_estimate": None, "noise": None, "bias": None, "main_cause": None}
    assert render_progress.line(unknown) == "Pass 3/64 | Photons 3.1 M | Time 1:12"
    assert render_progress.line({**progress, "pass": 0}) == "Looking where the light goes, then the first of 64 passes | Time 1:12"
    assert render_progress.line({**progress, "state": 'compiling'}) == "Building the scene | Time 1:12"
    assert [render_progress.percent(error) for error in (0.00834, 0.1, 1.234, 0)] == ["0.83 %", "10 %", "120 %", "0 %"]
    assert [render_progress.count(n) for n in (0, 9999, 10000, 2.5e9)] == ["0", "9,999", "10.0 k", "2.5 G"]


def test_a_target_that_the_passes_miss_is_told():
    """From a quarter of the passes on, and at the end."""
    from sluice import render_progress
    progress = {"state": 'rendering', "pass": 16, "passes": 64, "photons": 1, "seconds": 8, "seconds_left": 24, "error_estimate": 0.05,
                "noise": 0.04, "bias": 0.03, "main_cause": None, "passes_to_target": 412.3, "stop_reason": 'passes', "message": ""}
    assert render_progress.line(progress, 2).endswith("| Left 0:24 | 2 % takes about 410 passes")
    for other in ({"pass": 15}, {"passes_to_target": 60.0}, {"passes_to_target": None}):
        assert render_progress.line({**progress, **other}, 2).endswith("| Left 0:24")
    assert render_progress.line(progress, 0).endswith("| Left 0:24")
    done = {**progress, "state": 'finished', "pass": 64}
    assert render_progress.summary(done, 2) == ("all passes done: 64 of 64 passes, 1 photons, 8.0 s, error 5 % (noise 4 %, blur 3 %), "
                                                "2 % takes about 410 passes")
    for told, target in ((done, 0), (done, 6), ({**done, "passes_to_target": None}, 2)):
        assert render_progress.summary(told, target).endswith("blur 3 %)")


def test_the_end_tells_the_cost_of_the_target(edited_scene, fake_core, capsys, monkeypatch):
    """The session tells it only while it renders."""
    monkeypatch.setattr(fake_core, "seconds_per_photon", 1e-4)
    edited_scene.sluice.error_target, edited_scene.sluice.passes = 2, 4
    bpy.ops.render.render()
    said = capsys.readouterr().out
    assert "sluice: all passes done: 4 of 4 passes" in said and "most of the error: Direct, 75 %, 2 % takes about 24 passes\n" in said


def test_the_log_and_the_tooltip_tell_the_error(fake_core, monkeypatch, tmp_path):
    from sluice import final, render_progress
    monkeypatch.setenv("SLUICE_PROGRESS_LOG", str(tmp_path / "log.jsonl"))
    engine = Engine()
    engine.job = job_of_engine()
    engine.job.settings.update(passes=2)
    final.render(engine)
    last = json.loads((tmp_path / "log.jsonl").read_text().splitlines()[-1])
    assert (last["noise"], last["bias"], last["main_cause"]) == (0.4 / 3, 0.3 / 3, ["Direct", 0.75])
    assert render_progress.ERROR in bpy.context.scene.sluice.bl_rna.properties["error_target"].description
