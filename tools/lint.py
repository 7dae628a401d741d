#!/usr/bin/env python3
"""Runs clang-tidy over src/ and tools/, several files of a folder at a time.

Nearly all of clang-tidy's time goes into the headers that a file includes. So files of one folder with the same compiler flags are
joined into one, headers are read once for all of them, and what is found is told of the files as they are. Files that do not compile
together, because two define one name in their anonymous namespaces, are read apart.

usage: tools/lint.py [--quick] BUILD_DIR [FILE ...]     BUILD_DIR has compile_commands.json, of a build with HGG_FAST_BUILD=OFF
Without files: all of git's. --quick: without the static analyzer, which follows the paths through every function and takes a third of the
time. Exit status 1: something was found.
"""
import concurrent.futures
import json
import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

REPO = Path(__file__).resolve().parent.parent
TOGETHER = 8  # files: more save little time, and one core has all the work in the end


def wanted(names):
    if names:
        return [Path(name).resolve() for name in names]
    listed = subprocess.run(["git", "-C", REPO, "ls-files", "src/*.cpp", "tools/*.cpp"], capture_output=True, text=True, check=True)
    return [REPO / name for name in listed.stdout.split()]


def flags_of(entry):
    """The compiler's arguments without what names the file."""
    words, kept, skip = shlex.split(entry["command"]), [], False
    start = next(k for k, word in enumerate(words) if re.search(r"(^|/)(c|g|clang)\+\+[-\d]*$", word)) + 1
    for word in words[start:]:
        if not skip and word not in ("-c", "-o") and Path(entry["directory"], word).resolve() != Path(entry["file"]).resolve():
            kept.append(word)
        skip = word == "-o"
    return kept


def groups(build, files):
    """(directory, flags, files) that are read as one."""
    entries = {Path(e["file"]).resolve(): e for e in json.loads((build / "compile_commands.json").read_text())}
    alike = {}
    for file in files:
        if file not in entries:
            sys.exit(f"lint: {file} is not in {build}/compile_commands.json: configure again")
        entry = entries[file]
        alike.setdefault((file.parent, entry["directory"], tuple(flags_of(entry))), []).append(file)
    for (folder, directory, flags), members in alike.items():
        for k in range(0, len(members), TOGETHER):
            yield directory, [*flags, f"-I{folder}"], members[k:k + TOGETHER]


class Joined:
    """One file out of several, which knows where its lines come from."""

    def __init__(self, path, members):
        self.path, self.origin, text = path, [], []
        for member in members:
            for number, line in enumerate(member.read_text().splitlines(), 1):
                text.append("" if line.startswith("#pragma once") else line)
                self.origin.append((member, number))
        path.write_text("\n".join(text) + "\n")

    def told(self, line):
        """A line of output with the place in the joined file replaced by that in its source."""
        def place(match):
            member, number = self.origin[min(int(match[1]), len(self.origin)) - 1]
            return f"{member.relative_to(REPO)}:{number}"
        return re.sub(re.escape(str(self.path)) + r":(\d+)", place, line)


def check(directory, flags, members, build, more):
    name = str(members[0].relative_to(REPO)).replace("/", "_")
    joined = Joined(build / "together" / f"{len(members)}_{name}", members)
    if len(members) > 1 and subprocess.run(["c++", "-fsyntax-only", "-w", *flags, str(joined.path)], cwd=directory,
                                           capture_output=True).returncode:  # far sooner than clang-tidy would say so
        half = len(members) // 2
        parts = [check(directory, flags, part, build, more) for part in (members[:half], members[half:])]
        return max(status for status, _ in parts), [line for _, lines in parts for line in lines]
    command = ["clang-tidy", "--quiet", f"--config-file={REPO / '.clang-tidy'}", *more, str(joined.path), "--", *flags]
    done = subprocess.run(command, cwd=directory, capture_output=True, text=True)
    errors = [line for line in done.stderr.splitlines() if "error" in line.lower()]
    lines = [joined.told(line) for line in done.stdout.splitlines() + (errors if done.returncode else [])]
    return done.returncode, lines


def main(argv):
    more = ["--checks=-clang-analyzer-*"] if "--quick" in argv else []
    argv = [word for word in argv if word != "--quick"]
    if len(argv) < 2 or argv[1].startswith("-"):
        print(__doc__)
        return 0 if "--help" in argv else 2
    build = Path(argv[1]).resolve()
    (build / "together").mkdir(exist_ok=True)
    work = list(groups(build, wanted(argv[2:])))
    found = 0
    with concurrent.futures.ThreadPoolExecutor(int(os.environ.get("JOBS", os.cpu_count()))) as pool:
        tasks = {pool.submit(check, *group, build, more): group[2] for group in work}
        for done, task in enumerate(concurrent.futures.as_completed(tasks), 1):
            status, lines = task.result()
            found += status != 0
            print(f"[{done}/{len(tasks)}] {' '.join(m.name for m in tasks[task])}", *lines, sep="\n", flush=True)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
