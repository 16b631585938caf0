# SPDX-License-Identifier: GPL-3.0-or-later
"""The page of a report: one HTML file that needs no other. What it says in numbers stands in report.json."""

from html import escape
from pathlib import Path

import numpy as np
import report_measures as measures
import report_plots as plots

STYLE = """body { font: 15px/1.5 "DejaVu Sans", sans-serif; color: #22252a; max-width: 70em; margin: 2em auto; padding: 0 1em }
h1 { font-size: 1.6em } h2 { font-size: 1.15em; margin-top: 2em } table { border-collapse: collapse; margin: .7em 0 }
td, th { padding: .2em .8em; border-bottom: 1px solid #d8dade; text-align: right; vertical-align: top } th { font-weight: bold }
td { white-space: nowrap } td:first-child, th:first-child, td.words { text-align: left } .wide { overflow-x: auto }
tr.best { background: #f7e6ef } img { max-width: 100% }
.side { display: flex; flex-wrap: wrap; gap: 1em } .side > * { flex: 1 1 30em; min-width: 0; overflow-x: auto }
.small { color: #5c6773; font-size: .9em }
figure { display: inline-block; margin: .4em } figcaption { font-size: .85em }"""


# --- words and tables --------------------------------------------------------------------------------------------------------------


def percent(value) -> str:
    return "–" if value is None else f"{100 * value:.3g} %"


def number(value, digits: int = 3) -> str:
    """Short, with M and k."""
    if value is None:
        return "–"
    for size, letter in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if abs(value) >= size:
            return f"{value / size:.{digits}g}{letter}"
    return f"{value:.{digits}g}"


def seconds(value) -> str:
    return "–" if value is None else f"{value:.2f} s" if value < 10 else f"{value:.0f} s"


def table(heads: list[str], rows: list[list], marked=()) -> str:
    """Numbers to the right, sentences to the left; marked rows stand out."""
    def cell(value):
        kind = " class=words" if len(str(value)) > 20 else ""
        return f"<td{kind}>{escape(str(value))}</td>"

    lines = ["<div class=wide><table><tr>" + "".join(f"<th>{escape(head)}</th>" for head in heads) + "</tr>"]
    for i, row in enumerate(rows):
        lines.append(f"<tr{' class=best' if i in marked else ''}>" + "".join(map(cell, row)) + "</tr>")
    return "\n".join(lines) + "</table></div>"


def image(source: str | None, words: str) -> str:
    return f'<img src="{source}" alt="{escape(words)}">' if source else f"<p class=small>{escape(words)}: nothing to draw</p>"


def figure(path: Path, words: str) -> str:
    """A picture of a file with words below it."""
    return f"<figure>{image(plots.picture(np.load(path)), words)}<figcaption>{escape(words)}</figcaption></figure>"


def document(title: str, parts: list[str]) -> str:
    body = "\n".join(part for part in parts if part)
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{STYLE}</style>'
    return f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head>\n<body>\n{body}\n</body></html>\n'


# --- sections ----------------------------------------------------------------------------------------------------------------------


def heading(report: dict) -> str:
    settings = report["settings"]
    cause = report["main_cause"]
    size = f"{report['size'][0]} × {report['size'][1]} pixels, frame {report['frame']}"
    words = [f"{size}, {settings['passes']} passes of {settings['photons']:,} photons, seed {settings['seed']}",
             f"Sluice {report['versions']['sluice']}, Blender {report['versions']['blender']}, {report['threads']} threads of {report['processor']}",
             f"most of the error: {cause[0]} ({percent(cause[1])} of its square)" if cause else "what makes most of the error is not known",
             f"reference: {reference_words(report['reference'])}"]
    words += [f"not met before the first pass, so no estimate knows of it: {item['name']}" for item in report["unmet"]]
    words += [f"warning: {item}: {message}" for item, message in report["warnings"]]
    return f"<h1>{escape(report['name'])}: what accuracy costs</h1><p>" + "<br>".join(map(escape, words)) + "</p>"


def reference_words(reference: dict | None) -> str:
    if not reference:
        return "none; the error is the render's own estimate"
    if reference["passes"] is None:
        return reference["from"]
    own = f"its own estimated noise {percent(reference['noise'])}, bias {percent(reference['bias'])}"
    return f"{reference['from']}; {reference['passes']} passes, {seconds(reference['seconds'])}, {own}"


def costs(report: dict) -> str:
    rows = []
    for row in report["costs"]:
        about, how = ("", "measured") if row["measured"] else ("~ ", "extrapolated")
        passes, time = f"{about}{row['pass']:,}", about + seconds(row["seconds"])
        rows.append([percent(row["error"]), passes, time, number(row["rays"]), number(row["photons"]), how])
    words = ("Extrapolated (~) from the last estimate: noise² falls as 1 / passes, bias² as passes^(−2/3). Seconds hold the guide and are of this "
             "machine.")
    heads = ["error", "passes", "seconds", "rays", "photons", "how it is known"]
    return f"<h2>What an error costs</h2>{table(heads, rows)}<p class=small>{words}</p>"


def checkpoints(report: dict, folder: Path) -> str:
    """Figures and pictures on the way."""
    rows, shown = [], []
    for row in report["checkpoints"]:
        beside = row["against"] or {}
        rows.append([row["pass"], seconds(row["seconds"]), number(row["rays"]), number(row["photons"]), percent(row["error"]), percent(row["noise"]),
                     percent(row["bias"]), percent(beside.get("true")), percent(beside.get("true_without_reference_noise")),
                     number(beside.get("relmse")), number(beside.get("flip"))])
        words = f"{row['pass']} pass{'es' if row['pass'] > 1 else ''}, {seconds(row['seconds'])}"
        words += f", relMSE {number(beside['relmse'])}, FLIP {number(beside['flip'])}" if beside else ""
        shown.append(figure(folder / f"kept_{row['pass']}.npy", words))
    if report["reference"]:
        shown.append(figure(folder / "reference.npy", "reference"))
    heads = ["passes", "seconds", "rays", "photons", "error", "noise", "bias", "true error", "true, without the reference's noise", "relMSE", "FLIP"]
    words = ("Error, noise and bias are estimates, known from the fourth pass on. The true error is by the same definition, the reference in the "
             "place of the limit; relMSE is its square with the worst 0.1 % of the pixels.")
    if report["reference"] and report["flip"] != "measured":
        words += f" FLIP: {report['flip']}."
    return "<h2>On the way</h2>" + table(heads, rows) + f"<p class=small>{words}</p>" + "".join(shown)


def effects(report: dict) -> str:
    """What makes the error, and what it takes."""
    last = report["accuracy"][-1] if report["accuracy"] else None
    whole = sum(part["noise"] ** 2 + part["bias"] ** 2 for part in last["parts"]) if last else 0
    rows = []
    for part in last["parts"] if last else []:
        square = part["noise"] ** 2 + part["bias"] ** 2
        rows.append([part["name"], percent(part["noise"]), percent(part["bias"]), percent(square / whole if whole else None)])
    rows += [[f"of them the edit {edit['name']}", percent(edit["noise"]), "–", "–"] for edit in (last["edits"] if last else [])]
    title = report["name"]
    kinds = (("parts", "by effect"), ("edits", "by edit"))
    curves = [image(plots.shares_curve(f"{title}: {words}", report["accuracy"], kind), words) for kind, words in kinds]
    work = [[row["name"], "ran" if row["runs"] else "did not run", seconds(row["seconds"]), number(row["rays"]), number(row["photons_stored"]),
             number(row["bytes"]), row["why"]] for row in report["effects"]]
    words = ("Of one pass: how much less it takes without the effect. Photons serve several effects, and where one is off samples go elsewhere: rows "
             f"do not add up, and may fall below 0. A stored photon takes {report['bytes_per_photon']:.0f} bytes with its grid.")
    return ("<h2>By effect and edit</h2><div class=side><div>" + "</div><div>".join(curves) + "</div></div>"
            + table(["at the end", "noise", "bias", "share of the square"], rows)
            + "<h2>What effects take</h2>" + table(["effect", "state", "seconds", "rays", "photons stored", "bytes", "why"], work)
            + f"<p class=small>{words}</p>")


def maps(report: dict, folder: Path) -> str:
    """Of both errors, with one scale."""
    combined, noise, bias = (np.load(folder / f"{name}.npy") for name in ("main", "noise", "bias"))
    found = {"Estimated, of noise and bias together": measures.error_map(combined, noise, bias)}
    if report["reference"]:
        squares = measures.error_squares(combined, np.load(folder / "reference.npy"))
        found["Against the reference"] = np.sqrt(measures.box_mean(squares, 1))
    high = max(float(np.percentile(list(found.values()), 99)), 1e-6)
    drawn = [image(plots.heat_map(title, values, high), title) for title, values in found.items()]
    return "<h2>Where the error is</h2>" + _side_by_side(drawn) + placement(folder)


def _side_by_side(drawn: list[str]) -> str:
    return "<div class=side><div>" + "</div><div>".join(drawn) + "</div></div>"


def placement(folder: Path) -> str:
    """Where adaptive sampling spends its work, pixel by pixel of one pass."""
    counts = np.load(folder / "samples.npy")
    samples, emission, lights, segments = (counts[..., i] for i in range(4))
    found = {"View samples of a pass": samples, "Samples of lamps' edges alone": emission,
             "Lights asked in a pass": samples * lights, "Gather segments of a pass": samples * segments}  # fmt: skip
    drawn = [image(plots.heat_map(title, values / 100, max(float(values.max()), 1) / 100, "of a pixel"), title) for title, values in found.items()]
    return "<h2>Where view samples go</h2>" + _side_by_side(drawn)


def settings(report: dict) -> str:
    """Neighbouring settings, and the balance of photons and view samples."""
    found = report["alternatives"]
    balance = report["balance"]
    share = percent(balance["photon_share"])
    words = f"Photons took {seconds(balance['photon_seconds'])} ({share} of the time), view samples {seconds(balance['view_seconds'])}."
    if len(found) < 2:
        return f"<h2>Balance</h2><p>{words}</p>"
    rows = []
    for row in found:
        mark = (" (cheapest)" if row["best"] else "") + (" (least work)" if row["least_work"] else "")
        rows.append([row["name"] + mark, percent(row["error"]), percent(row["true"]), seconds(row["seconds"]), number(row["work"]),
                     number(row["error_seconds"]), number(row["error_work"]), seconds(row["same_error_seconds"]), number(row["same_error_work"]),
                     percent(row["photon_share"])])
    heads = ["setting", "error", "true error", "seconds", "rays + photons", "error × seconds", "error × (rays + photons)",
             "seconds to the same error", "rays + photons to it", "photons' time"]
    told = {row["name"]: row for row in found}
    for name in ("photons × ½", "photons × 2"):
        if name in told and told[name]["same_error_seconds"]:
            other, now = told[name], found[0]
            words += (f" With {name} the error went from {percent(now['error'])} to {percent(other['error'])} in {seconds(other['seconds'])} "
                      f"instead of {seconds(now['seconds'])}: {other['same_error_seconds'] / now['seconds']:.2f} times the time to the same error.")
    small = ("Error × work favours whatever does less; the cheapest is the one that comes to the present error in the least time (by the laws of the "
             "table of costs), the guide apart. Differences of a tenth may be chance.")
    marked = [i for i, row in enumerate(found) if row["best"]]
    return ("<h2>Settings that would be cheaper at the same error</h2>" + table(heads, rows, marked) + f"<p class=small>{small}</p>"
            f"<h2>Photons and view samples</h2><p>{escape(words)}</p>")


def page(report: dict, folder: Path) -> str:
    """The whole page; pictures come from the folder that tools/report_render.py filled."""
    curve = plots.error_curve(f"{report['name']}: error against time", report["accuracy"], report["checkpoints"])
    return document(f"Sluice: {report['name']}", [heading(report), "<h2>Error against time</h2>", image(curve, "error against time"), costs(report),
                    checkpoints(report, folder), effects(report), maps(report, folder), settings(report)])


def compared(reports: dict[str, dict]) -> str:
    """Two reports side by side."""
    curve = plots.compared_curves({name: report["accuracy"] for name, report in reports.items()})
    sides = []
    for name, report in reports.items():
        rows = [[row["pass"], seconds(row["seconds"]), number(row["rays"] + row["photons"]), percent(row["error"]), percent(row["noise"]),
                 percent(row["bias"]), percent((row["against"] or {}).get("true"))] for row in report["checkpoints"]]
        heads = ["passes", "seconds", "rays + photons", "error", "noise", "bias", "true error"]
        sides.append(f"<div><h2>{escape(name)}</h2>{heading(report).replace('h1>', 'h3>')}{table(heads, rows)}{costs(report)}</div>")
    return document("Sluice: " + " and ".join(reports), [f"<h1>{escape(' and '.join(reports))}</h1>", image(curve, "error against time"),
                    "<div class=side>" + "\n".join(sides) + "</div>"])
