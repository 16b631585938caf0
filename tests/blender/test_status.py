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
                "error_estimate": 0.0521, "stop_reason": 'passes', "message": ""}
    assert render_progress.line(progress) == "Pass 3/64 | Photons 3.1 M | Time 1:12 | Left 1:02:03 | Noise 5.2 %"
    assert render_progress.line({**progress, "unmet": ["Sun"]}).endswith("Noise 5.2 % (without Sun: not met)")
    assert render_progress.line({**progress, "unmet": ["Sun", "World", "Dome"]}).endswith("Noise 5.2 % (without Sun, World …: not met)")
    assert render_progress.line({**progress, "seconds_left": None, "error_estimate": None}) == "Pass 3/64 | Photons 3.1 M | Time 1:12"
    assert render_progress.line({**progress, "pass": 0}) == "Looking where the light goes, then the first of 64 passes | Time 1:12"
    assert render_progress.line({**progress, "state": 'compiling'}) == "Building the scene | Time 1:12"
    assert [render_progress.count(n) for n in (0, 9999, 10000, 2.5e9)] == ["0", "9,999", "10.0 k", "2.5 G"]
