# SPDX-License-Identifier: GPL-3.0-or-later
"""./run same REF [--no-instructions]: do this tree and a revision of it make the same pictures, bit by bit?

Builds the revision in out/same/, copies the demo scenes and the bench's two boxes with the add-on of each tree, renders them small with
the core of each (with edits, without, and recompiled as in the viewport), and compares descriptions, film and guide hashes. Then
compares the instructions that three renders take (valgrind). Exit status 1: something differs."""
import argparse
import hashlib
import json
import os
import pickle
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "out" / "same"
TOOLS = ROOT / "tools"
COUNTED = ("cornell", "glass_egg", "box, large lamp")
MAX_CHANGE = 0.003  # of instructions
FIRST = "1d5ded6"  # older revisions do not give one file one hash


def run(*command, **more):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **more)
    if done.returncode:
        raise SystemExit(f"same: {' '.join(map(str, command[:4]))} … ended with {done.returncode}:\n{(done.stdout + done.stderr)[-3000:]}")
    return done


def git(*arguments):
    return run("git", "-C", ROOT, *arguments).stdout.strip()


class Tree:
    """Sources, their build, and what they make of the scenes."""

    def __init__(self, root, build, results):
        self.root, self.build, self.results = root, build, results
        self.scenes = results / "scenes.pickle"
        results.mkdir(parents=True, exist_ok=True)

    @property
    def environment(self):
        return {**os.environ, "SLUICE_CORE": str(self.build), "BLENDER_USER_SCRIPTS": str(self.build / "scripts"), "PYTHONPATH": str(self.build),
                "PYTHONHASHSEED": "0"}

    def copy_scenes(self):
        environment = {key: value for key, value in self.environment.items() if key != "PYTHONPATH"}
        run("blender", "-b", "--factory-startup", "--addons", "sluice", "--python-exit-code", "1", "--python", TOOLS / "same_scenes.py", "--",
            self.root, self.scenes, env=environment)

    def remembered_hashes(self):
        """Those of a revision, which cannot change but by the programs that ask for them."""
        programs = b"".join((TOOLS / name).read_bytes() for name in ("same_scenes.py", "same_films.py"))
        path = self.results / f"hashes_{hashlib.sha256(programs).hexdigest()[:12]}.json"
        if not path.exists():
            self.copy_scenes()
            path.write_text(json.dumps([[*key, value] for key, value in self.hashes().items()]))
        return {(scene, what): value for scene, what, value in json.loads(path.read_text())}

    def hashes(self):
        """{(scene, what): hash}"""
        found = {(name, "description"): scene["hash"] for name, scene in pickle.loads(self.scenes.read_bytes()).items()}
        for line in run(sys.executable, TOOLS / "same_films.py", self.scenes, env=self.environment).stdout.splitlines():
            scene, way, film, guide = json.loads(line)
            found[scene, f"{way}: film"], found[scene, f"{way}: guide"] = film, guide
        return found

    def instructions(self, scene):
        """Of a render: those of the whole program less those of it without the render."""
        def count(*more):
            program = (sys.executable, TOOLS / "same_films.py", self.scenes, scene, *more)
            counted = run("valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *program, env=self.environment)
            return int(re.search(r"Collected : (\d+)", counted.stderr)[1])
        return count() - count("idle")


def build_revision(commit):
    """The tree of a commit, built once."""
    place = OUT / commit
    source = place / "source"
    if not source.exists():
        fresh = place / "unpacked"
        shutil.rmtree(fresh, ignore_errors=True)
        fresh.mkdir(parents=True)
        archive = subprocess.run(["git", "-C", ROOT, "archive", commit], capture_output=True, check=True).stdout
        subprocess.run(["tar", "-x", "-C", fresh], input=archive, check=True)
        fresh.rename(source)
    build = source / "build"
    if not list(build.glob("sluice_core*.so")):
        print(f"building {commit[:10]} …", flush=True)
        run("cmake", "--preset", "release", "-DSLUICE_TESTS=OFF", cwd=source)
        run("ninja", "-C", build, "sluice_core")
    (build / "scripts" / "addons").mkdir(parents=True, exist_ok=True)
    link = build / "scripts" / "addons" / "sluice"
    if not link.exists():
        link.symlink_to(source / "addon")
    return Tree(source, build, place)


def compare_hashes(before, after):
    different = sorted(key for key in before.keys() | after.keys() if before.get(key) != after.get(key))
    for scene, what in different:
        print(f"  differs: {scene}, {what}")
    print(f"hashes: {len(before.keys() | after.keys()) - len(different)} equal, {len(different)} differ", flush=True)
    return not different


def compare_instructions(before, after):
    is_same = True
    for scene in COUNTED:
        old, new = before.instructions(scene), after.instructions(scene)
        change = new / old - 1
        is_same = is_same and change <= MAX_CHANGE
        print(f"instructions: {scene}: {old:,} -> {new:,}, {change:+.2%}{'' if abs(change) <= MAX_CHANGE else '  <-'}", flush=True)
    return is_same


def main():
    parser = argparse.ArgumentParser(prog="./run same", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("revision", help="commit, branch or tag to compare with")
    parser.add_argument("--no-instructions", action="store_true", help="compare hashes alone")
    options = parser.parse_args()
    commit = git("rev-parse", "--verify", options.revision + "^{commit}")
    if subprocess.run(["git", "-C", str(ROOT), "merge-base", "--is-ancestor", FIRST, commit], capture_output=True).returncode:
        raise SystemExit(f"same: {options.revision} is older than {FIRST}, from which on one file has one hash")
    before, after = build_revision(commit), Tree(ROOT, ROOT / "build", OUT / "here")
    after.copy_scenes()
    is_same = compare_hashes(before.remembered_hashes(), after.hashes())
    if not options.no_instructions:
        is_same = compare_instructions(before, after) and is_same
    return 0 if is_same else 1


if __name__ == "__main__":
    sys.exit(main())
