"""Runs the libFuzzer targets of a build folder, each for as long as it is told, and says what came of it.

Prints one line per target (runs, edges covered, inputs found) and "N targets, N failed" alone on the
last line. A crash, a leak, a broken promise or an input that takes too long ends a target and fails it;
the input lies in --out, and `BUILD/tests/fuzz/TARGET INPUT` shows it again. What was found stays in
BUILD/corpus/TARGET, where the next run begins.
"""

import argparse
import concurrent.futures
import re
import resource
import subprocess
import sys
import time
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]

# target: largest input, stored inputs below tests/data, dictionary
TARGETS = {
    "glb_fuzz": (4096, ["hostile/cases"], None),
    "json_fuzz": (8192, ["hostile/cases", "scenes", "import"], "gltf.dict"),
    "import_fuzz": (8192, ["hostile/cases", "scenes", "import"], "gltf.dict"),
    "accessor_fuzz": (1024, ["accessor"], None),
    "meshopt_fuzz": (4096, ["meshopt"], None),
    "draco_fuzz": (2048, ["draco"], None),
    "pov_fuzz": (2048, ["pov"], None),
    "trees_fuzz": (8192, ["trees"], None),
    "ray_json_fuzz": (4096, ["ray_json"], "ray_json.dict"),
    "box_json_fuzz": (4096, ["box_json"], "box_json.dict"),
    "ray_lines_fuzz": (4096, ["ray_lines"], "ray_json.dict"),
    "ray_binary_fuzz": (4096, ["ray_binary"], None),
    "point_json_fuzz": (4096, ["point_json"], "ray_json.dict"),
    "sweep_json_fuzz": (4096, ["sweep_json"], "ray_json.dict"),
    "node_json_fuzz": (4096, ["node_json"], None),
    "scene_record_fuzz": (4096, ["scene_record"], None),
    "content_coding_fuzz": (2048, ["content_coding"], None),
    "settings_fuzz": (2048, ["settings"], None),
    "framing_fuzz": (2048, ["framing"], "framing.dict"),
}

# A hang is what is a hundred times slower than the slowest stored input, with the sanitizers in it.
SLOWEST_SECONDS = 10
TIMEOUT_CODE = 70
MEMORY_MIB = 1024


def run(target, options):
    longest, stored, words = TARGETS[target]
    found, out = options.build / "corpus" / target, options.out / target
    found.mkdir(parents=True, exist_ok=True)
    out.mkdir(parents=True, exist_ok=True)
    program = options.build / "tests/fuzz" / target
    command = [program, f"-max_len={longest}", f"-timeout={SLOWEST_SECONDS}", f"-rss_limit_mb={MEMORY_MIB}", f"-artifact_prefix={out}/",
               "-print_final_stats=1", "-reload=0"]
    if words:
        command.append(f"-dict={SOURCE / 'tests/fuzz' / words}")
    if options.seed:
        command.append(f"-seed={options.seed}")
    command += [found, *(SOURCE / "tests/data" / folder for folder in stored)]
    began = time.monotonic()
    (out / "log").write_text("")
    while True:
        left = max(1, options.seconds - int(time.monotonic() - began))
        with open(out / "log", "a", encoding="utf-8") as log:
            code = subprocess.run([*map(str, command[:1]), f"-max_total_time={left}", *map(str, command[1:])],
                                  stdout=log, stderr=subprocess.STDOUT, cwd=out, check=False).returncode
        if code != TIMEOUT_CODE or is_slow_again(program, out):
            break
        # The machine stood still: nothing was found.
        if time.monotonic() - began >= options.seconds:
            code = 0
            break
    return describe(target, code, (out / "log").read_text(encoding="utf-8", errors="replace"),
                    time.monotonic() - began, out), code == 0


def is_slow_again(program, out):
    """Whether the newest input that took too long takes too long alone as well, by processor time."""
    slow = max(out.glob("timeout-*"), key=lambda file: file.stat().st_mtime)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(program), f"-timeout={100 * SLOWEST_SECONDS}", str(slow)], capture_output=True, check=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode == 0 and after.ru_utime - before.ru_utime < SLOWEST_SECONDS:
        slow.unlink()
        return False
    return True


def describe(target, code, log, seconds, out):
    def last(pattern):
        matches = re.findall(pattern, log)
        return matches[-1] if matches else "?"

    runs = last(r"stat::number_of_executed_units:\s*(\d+)")
    if runs == "?":
        runs = last(r"^#(\d+)\s(?m:)") if code == 0 else last(r"#(\d+)\s")
    verdict = "no crash, leak or hang"
    if code != 0:
        artifacts = [file for file in out.iterdir() if file.name != "log"]
        newest = max(artifacts, key=lambda file: file.stat().st_mtime, default=out / "log")
        why = re.search(r"broken promise: .*|ERROR: .*?(?= on | \(|$)", log, re.MULTILINE)
        verdict = f"FAILED with code {code}: {why.group(0) if why else '?'}; see {newest}"
    slowest = last(r"stat::slowest_unit_time_sec:\s*(\d+)")
    return (f"{target:20}{int(seconds):4} s  {runs:>10} runs  {last(r'cov: ([0-9]+)'):>6} edges  "
            f"{last(r'corp: ([0-9]+)/'):>5} inputs  slowest {slowest} s  {verdict}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", type=Path, default=SOURCE / "build/fuzz")
    parser.add_argument("--out", type=Path, default=SOURCE / "build/stress/fuzz", help="logs and failing inputs")
    parser.add_argument("--minutes", type=float, default=10, help="for each target")
    parser.add_argument("--jobs", type=int, default=2, help="targets at once")
    parser.add_argument("--target", action="append", choices=sorted(TARGETS), help="only this one; may be repeated")
    parser.add_argument("--seed", type=int, default=0, help="of libFuzzer; 0: another one each time")
    parser.add_argument("--list", action="store_true", help="print the targets' names and end")
    options = parser.parse_args()
    names = options.target or list(TARGETS)
    if options.list:
        print(*names, sep="\n")
        return 0
    options.build, options.out = options.build.resolve(), options.out.resolve()
    options.seconds = max(1, round(options.minutes * 60))
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(max_workers=options.jobs) as pool:
        for line, is_good in pool.map(lambda name: run(name, options), names):
            print(line, flush=True)
            failed += not is_good
    print(f"{len(names)} targets, {failed} failed", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
