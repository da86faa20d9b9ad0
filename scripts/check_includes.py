#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Checks who includes whom (CONTRIBUTING.md), SPDX lines, that no file names a folder of somebody's machine, and that no two
headers declare a type or a function of one name.

scripts/check_includes.py [ROOT]     prints every violation as file:line and ends with status 1 when there is one
"""
import pathlib
import re
import subprocess
import sys

# Header prefix -> the only folders that may include it.
VENDORS = {
    "dds/": ["common/bus/cyclone", "tests/process"],
    "ddsc": ["common/bus/cyclone"],
    "fastdds/": ["common/bus/fast", "tests/unit/bus", "tests/process"],
    "fastrtps/": ["common/bus/fast", "tests/unit/bus", "tests/process"],
    "fastcdr/": ["common/messages", "common/bus/fast"],
    "urdf_": ["servers/model_parser", "diagnosis/generator"],
    "tinyxml2": ["servers/model_parser"],
    "console_bridge": ["servers/model_parser"],
    "fcl/": ["servers/collision_checker"],
    "png.h": ["common/robot"],
    "yaml-cpp/": ["common/robot", "diagnosis", "controller/motion", "servers/console/topic_tool"],
    "zstd": ["common/mcap"],
    "lz4": ["common/mcap", "tests"],
    "libdeflate": ["common/mcap"],
    "sqlite3": ["common/log", "tests"],
    "bzlib": ["common/log", "tests"],
    "mujoco/": ["servers/mujoco_dynamics", "servers/model_parser/mjcf", "tests", "diagnosis/generator"],
    "sdf/": ["servers/model_parser/sdf"],
    "dart/": ["tests"],
    "embree3/": ["servers/vision/embree"],
    "ceres/": ["diagnosis"],
    "boost/": ["servers/viewer"],
    "openssl/": ["common/base", "common/bus", "common/node"],
    "pybind11/": ["python"],
    "CLI/": ["common/base", "common/node", "servers", "controller", "diagnosis", "tests", "models"],
}

# Folder -> folders of common/ that it may include, beside itself.
COMMON = {
    "base": [],
    "spatial": [],
    "multibody": ["base", "spatial"],
    "effects": ["base", "spatial", "multibody"],
    "robot": ["base", "spatial", "multibody", "effects"],
    "scene": ["base", "spatial", "multibody", "robot"],
    "mcap": ["base"],
    "bus": ["base"],
    "messages": ["base", "spatial", "multibody", "effects", "robot", "scene", "bus"],
    "node": ["base", "spatial", "multibody", "effects", "robot", "scene", "bus", "messages"],
    "log": ["base", "bus", "effects", "robot", "mcap", "messages"],
    "plot": ["base", "spatial", "multibody", "effects", "robot", "mcap", "messages"],
}

# Folders of the diagnosis that know no other folder of it beside those given. Whatever the others know, there is no
# cycle among them: find_cycle().
DIAGNOSIS = {
    "estimate": [],
    "data": ["estimate"],
    "model": ["data", "estimate"],
    "simulation": ["data", "estimate", "model"],
    "search": ["data", "estimate", "model", "simulation"],
    "page": [],
    "generator": [],
}

# Parts of a server that may know the bus: everything else in servers/ is core.
BUS_SIDE = re.compile(r"^servers/(console/.*|viewer/.*|[^/]+/(node|main|translate|engine)[^/]*\.(h|cpp))$")
BUS_HEADERS = ("common/bus/", "common/messages/", "common/node/", "hrp_idl/")
# The programs that run the whole set, or its cores, in one process put them together; the log tool shows all messages.
PUTS_SERVERS_TOGETHER = ("servers/console/launcher/", "servers/console/trial/")

INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
MACHINE_PATH = re.compile(r"(?<![\w.$}/])/(home|root|work|Users|mnt|workspace)/\w")
TEXT_FILES = {".h", ".cpp", ".idl", ".py", ".sh", ".md", ".txt", ".cmake", ".yaml", ".yml", ".json", ".mjs", ".csv", ".urdf"}


def folder_of(path, depth):
    return "/".join(path.split("/")[:depth])


def is_under(path, folder):
    return path.startswith(folder.rstrip("/") + "/")


def check_vendor(path, header):
    for prefix, folders in VENDORS.items():
        if header.startswith(prefix) and not any(is_under(path, folder) for folder in folders):
            return f"<{header}> belongs into {', '.join(folders)} only"
    return None


def check_direction(path, header):
    top = header.split("/")[0]
    if top not in ("common", "servers", "controller", "diagnosis", "tests", "hrp_idl"):
        return None
    if top == "tests" and not is_under(path, "tests"):
        return "nothing but tests includes tests"
    if is_under(path, "common"):
        return check_common(path, header)
    if is_under(path, "controller") and top in ("servers", "diagnosis"):
        return "the controller knows nothing of the simulator"
    if is_under(path, "servers"):
        return check_server(path, header)
    if is_under(path, "diagnosis") and re.match(r"servers/[^/]+/(node|main)", header):
        return "the diagnosis tool uses cores, never nodes"
    return None


def check_common(path, header):
    own = path.split("/")[1]
    if header.startswith("hrp_idl/"):
        return None if own in ("messages", "node", "plot", "bus", "log") else f"common/{own} knows no messages"
    if not header.startswith("common/"):
        return "common includes nothing above itself"
    other = header.split("/")[1]
    if own != other and other not in COMMON.get(own, []):
        return f"common/{own} may not include common/{other}"
    return None


def check_server(path, header):
    if is_under(path, "servers/model_parser") and header == "controller/motion/motion.h":
        return None  # a file format: where a motion begins, the robot starts
    if header.startswith(("diagnosis/", "controller/")) and not path.startswith(PUTS_SERVERS_TOGETHER):
        return "servers include neither the controller nor the diagnosis tool"
    if header.startswith("servers/") and folder_of(header, 2) != folder_of(path, 2):
        return None if path.startswith(PUTS_SERVERS_TOGETHER) else "servers never include each other"
    if header.startswith(BUS_HEADERS) and not BUS_SIDE.match(path):
        return "a core knows no bus and no messages"
    return None


def check_diagnosis(path, header):
    if not is_under(path, "diagnosis") or not is_under(header, "diagnosis"):
        return None
    own, other = path.split("/")[1], header.split("/")[1]
    if own == other or own not in DIAGNOSIS or other in DIAGNOSIS[own] or "/" not in header[len("diagnosis/"):]:
        return None
    return f"diagnosis/{own} may not include diagnosis/{other}"


def find_cycle(edges):
    """A way from a folder back to itself as a list of folders; None: there is none. `edges`: folder -> folders."""
    done = set()

    def walk(folder, way):
        if folder in way:
            return way[way.index(folder):] + [folder]
        if folder in done:
            return None
        for other in sorted(edges.get(folder, ())):
            cycle = walk(other, way + [folder])
            if cycle:
                return cycle
        done.add(folder)
        return None

    for start in sorted(edges):
        cycle = walk(start, [])
        if cycle:
            return cycle
    return None


def find_diagnosis_edges(path, lines, edges):
    if not is_under(path, "diagnosis") or path.count("/") < 2:
        return
    own = path.split("/")[1]
    for line in lines:
        match = INCLUDE.match(line)
        parts = match.group(1).split("/") if match else []
        if len(parts) > 2 and parts[0] == "diagnosis" and parts[1] != own:
            edges.setdefault(own, set()).add(parts[1])


def check_source(path, lines):
    if "SPDX-License-Identifier: BSD-3-Clause" not in lines[0]:
        yield 1, "the first line is no SPDX line"
    if path.endswith(".h") and "#pragma once" not in lines:
        yield 1, "a header without #pragma once"
    for number, line in enumerate(lines, 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        for check in (check_vendor, check_direction, check_diagnosis):
            problem = check(path, match.group(1))
            if problem:
                yield number, problem


FUNCTION = re.compile(r"(?!template|friend|using|static|return)[A-Za-z_][\w:<>,&* ]*[ &*](\w+)\(([^()]*)\)(?: noexcept)?(?:;| \{)")


def find_parameter_types(text):
    """"const Bag& bag, int n = 3" -> "const Bag&, int"."""
    parameters = [re.sub(r"\s*=.*", "", each).strip() for each in re.sub(r"<[^<>]*>", lambda part: part.group().replace(",", ";"), text).split(",")]
    return ", ".join(re.sub(r"(?<=[\w>&*]) ?(?<![:\w])\w+$", "", each).strip() for each in parameters)


def find_names(path, lines, names):
    """Types and functions that a header declares, by their whole names: two with one name are one to the linker, whatever
    they hold or do."""
    spaces = []
    for line in lines:
        space = re.match(r"(?:inline )?namespace ([\w:]+) \{", line)
        if space:
            spaces.append(space.group(1))
        elif line.startswith("}  // namespace") and spaces:
            spaces.pop()
        found = re.match(r"(?:struct|class|union|enum(?: class)?) (\w+)(?: final)?(?: : [^:].*)? \{", line)
        if found:
            names.setdefault("::".join(spaces + [found.group(1)]), set()).add(path)
        found = FUNCTION.match(line)
        if found:
            names.setdefault(f"{'::'.join(spaces + [found.group(1)])}({find_parameter_types(found.group(2))})", set()).add(path)


def find_files(root):
    listed = subprocess.run(["git", "-C", root, "ls-files", "--cached", "--others", "--exclude-standard"],
                            capture_output=True, text=True, check=False)
    if listed.returncode == 0:
        return listed.stdout.splitlines()
    found = (p.relative_to(root).as_posix() for p in pathlib.Path(root).rglob("*") if p.is_file())
    return [p for p in found if not p.startswith(("build", ".git/")) and "node_modules" not in p]


def main():
    if {"-h", "--help"} & set(sys.argv[1:]):
        print(__doc__.strip())
        return 0
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent)
    problems, count, edges, names = [], 0, {}, {}
    for path in sorted(find_files(str(root))):
        file = root / path
        if file.suffix not in TEXT_FILES or not file.is_file():
            continue
        count += 1
        lines = file.read_text(encoding="utf-8", errors="replace").splitlines() or [""]
        if file.suffix in (".h", ".cpp"):
            problems += [f"{path}:{number}: {text}" for number, text in check_source(path, lines)]
            find_diagnosis_edges(path, lines, edges)
        if file.suffix == ".h":
            find_names(path, lines, names)
        for number, line in enumerate(lines, 1):
            if MACHINE_PATH.search(line):
                problems.append(f"{path}:{number}: a path of somebody's machine")
    problems += [f"{' and '.join(sorted(places))}: both declare {name}" for name, places in names.items() if len(places) > 1]
    cycle = find_cycle(edges)
    if cycle:
        problems.append("diagnosis: folders include each other in a circle: " + " -> ".join(cycle))
    print("\n".join(problems) if problems else f"{count} files, nothing to complain about")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
