# SPDX-License-Identifier: GPL-3.0-or-later
"""A stand-in for the compiled core with the same names: paints a gradient in full-frame pixel coordinates, so that the add-on's
protocol (errors, warnings, cancel, passes, borders) is tested apart from the renderer. Its time is counted, not threaded."""
import copy
import re
import time

import numpy as np

__version__ = "0.1.0"
# Of each kind some; they need not be all that the core has.
passes = (("Combined", "RGBA"), ("Depth", "Z"), ("Normal", "XYZ"), ("Albedo", "RGB"), ("Direct", "RGB"), ("Emission", "RGB"), ("Noise", "X"),
          ("Bias", "X"))
last_description = None  # what the last session was given, for tests
last_settings = None
seconds_per_photon = 1e-8


class SceneError(ValueError):
    def __init__(self, item, message):
        super().__init__(message)
        self.item = item


class ExpressionError(SceneError):
    def __init__(self, item, column, message):
        super().__init__(item, message)
        self.column = column


def check_expression(text, names):
    """Knows only parentheses and letters: enough to be wrong at a column."""
    depth = 0
    for column, letter in enumerate(text, 1):
        depth += (letter == "(") - (letter == ")")
        if depth < 0:
            raise ExpressionError("", column, "this parenthesis closes nothing; remove it")
        if letter == "?" and column == 1:
            raise ExpressionError("", column, "nothing to repeat before ?")
    if depth:
        raise ExpressionError("", len(text) + 1, "a parenthesis is open; write )")
    unknown = [name for name in re.findall(r"'([^']*)'", text) if name not in names]
    side = 'view' if text.endswith("E") else 'light'
    return {"side": side, "warnings": [f"nothing is called {name}" for name in unknown]}


def parse(text):
    """A lone L, whatever the text."""
    check_expression(text, [])
    return ("atom", False, (("L", ()),))


def check_layer_expression(text, names):
    found = check_expression(text, names)
    if not text.startswith("L"):
        raise ExpressionError("", 1, "write L first")
    return {"warnings": found["warnings"]}


def blackbody(kelvin):
    """Redder below 6500 K and bluer above, and no more like the real one than that."""
    blue = min(max(kelvin, 965), 12000) / 6500
    return 1 / blue, 1.0, blue


class Session:
    def __init__(self):
        self._state, self._error, self._warnings = 'idle', None, []
        self.base = None  # whose things it shows

    def start(self, description, settings):
        global last_description, last_settings
        last_description, last_settings = copy.deepcopy(description), copy.deepcopy(settings)
        self._description, self._frame, self._settings = last_description, last_description["frame"], last_settings
        asked = {"Combined", "Noise", *last_settings.get("render_passes", [name for name, _channels in passes])}
        self._channels = {name: len(channels) for name, channels in passes if name in asked}
        self._channels.update({layer["name"]: 3 for layer in last_description.get("layers", ())})
        self._begin, self._state, self._stop = time.monotonic(), 'rendering', None
        for edit in last_description["edits"]:
            name = edit["entry"]["name"]
            if abs(np.linalg.det(edit["entry"]["matrix"][:3, :3])) < 1e-12:
                self._warnings.append((name, "the quad has no area; the edit is off"))
            try:
                check_expression(edit["expression"], [])
            except ExpressionError as error:
                self._state = 'failed'
                self._error = {"message": str(error), "item": name, "column": error.column}

    def start_from(self, base, shot, settings):
        if base._state in {'idle', 'failed'}:
            return False
        assert set(shot) <= {"camera", "frame", "edits", "layers", "max_gates"}
        self.start({**base._description, **shot}, settings)
        self.base = base
        return True

    def _advance(self):
        done = min(self._settings["passes"], int((time.monotonic() - self._begin) / (seconds_per_photon * self._settings["photons"])))
        limit = self._settings["time_limit"]
        if self._state != 'rendering':
            return self._done
        self._done = done
        if done == self._settings["passes"]:
            self._state, self._stop = 'finished', 'passes'
        elif limit and time.monotonic() - self._begin > limit:
            self._state, self._stop = 'finished', 'time'
        return done

    _done = 0

    def wait(self, seconds):
        end = time.monotonic() + seconds
        while self._state == 'rendering' and time.monotonic() < end:
            self._advance()
            time.sleep(0.002)
        self._advance()
        return self._state != 'rendering'

    def progress(self):
        done = self._advance()
        seconds = time.monotonic() - self._begin
        return {"state": self._state, "pass": done, "passes": self._settings["passes"], "photons": done * self._settings["photons"],
                "seconds": seconds, "seconds_left": 1.0, "error_estimate": 0.5 / (done + 1), "noise": 0.4 / (done + 1),
                "bias": 0.3 / (done + 1), "main_cause": ("Direct", 0.75) if done else None,
                "passes_to_target": self._to_target() if done else None, "memory": 1 << 20, "message": "",
                "error": self._error, "stop_reason": self._stop or 'cancelled'}

    def _to_target(self):
        target = self._settings["error_target"] / 100
        return 0.5 / target - 1 if target > 0 else None

    def cancel(self):
        if self._state == 'rendering':
            self._state = 'cancelled'

    def warnings(self):
        return list(self._warnings)

    def snapshot(self, names):
        if self._state == 'failed' or self._advance() == 0 or not self._channels.keys() >= set(names):
            return None
        frame = self._frame
        rows, columns = np.mgrid[frame["y0"]:frame["y1"], frame["x0"]:frame["x1"]].astype(np.float32)
        found = {}
        for name in names:
            image = np.empty((*rows.shape, self._channels[name]), np.float32)
            for channel in range(image.shape[2]):
                image[..., channel] = rows / frame["height"] + 10 * columns / frame["width"] + len(name)
            if name == "Combined":
                image[..., :3] /= 20
                image[..., 3] = 1
            found[name] = image
        return found

    def statistics(self):
        return {"report": "effects: direct ran", "effects": [("direct", True, "there is a light")]}

    def film_hash(self):
        return "0123456789abcdef"
