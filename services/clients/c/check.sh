#!/usr/bin/env bash
# Installs libclearway, builds the examples as users would, and compares what they print with
# `plan --local`, under AddressSanitizer and valgrind too: check.sh FOLDER PROGRAMS, where PROGRAMS
# has `planner`, `plan` and `raw-planner`. Needs a C and a C++ compiler, pkg-config, valgrind and Python; cmake if it is
# there.
set -euo pipefail
folder=$(realpath -m "$1")
programs=$(realpath "$2")
here=$(cd "$(dirname "$0")" && pwd)
scenes=$here/../../../recordings/scenes
rm -rf "$folder"
mkdir -p "$folder"
"$here/install.sh" "$folder/usr" dev
export PKG_CONFIG_PATH=$folder/usr/lib/pkgconfig LD_LIBRARY_PATH=$folder/usr/lib
export CLEARWAY_ROOT=$folder/root
# Sockets below it have short paths.
[ ${#CLEARWAY_ROOT} -le 40 ] || CLEARWAY_ROOT=$(mktemp -d)
read -ra flags <<<"$(pkg-config --cflags --libs clearway)"

compilers=("gcc g++")
command -v clang >/dev/null && command -v clang++ >/dev/null && compilers+=("clang clang++")
for pair in "${compilers[@]}"; do
    read -r cc cxx <<<"$pair"
    "$cc" -std=c11 -Wall -Wextra -Wpedantic -Werror -g "$here/examples/plan.c" "${flags[@]}" -o "$folder/c-$cc"
    "$cxx" -std=c++17 -Wall -Wextra -Wpedantic -Werror -g "$here/examples/plan.cpp" "${flags[@]}" -o "$folder/c++-$cc"
    "$cxx" -std=c++17 -fno-exceptions -Werror -fsyntax-only -I"$folder/usr/include" "$here/examples/plan.cpp"
    "$cc" -std=c11 -fsanitize=address,undefined -g "$here/examples/plan.c" "${flags[@]}" -o "$folder/sanitized-c-$cc"
    "$cxx" -std=c++17 -fsanitize=address,undefined -g "$here/examples/plan.cpp" "${flags[@]}" -o "$folder/sanitized-c++-$cc"
done
gcc -std=c11 "$here/examples/plan.c" -I"$folder/usr/include" "$folder/usr/lib/libclearway.a" \
    -lpthread -ldl -lm -lrt -o "$folder/static"
if command -v cmake >/dev/null; then
    mkdir "$folder/cmake"
    cat >"$folder/cmake/CMakeLists.txt" <<CMAKE
cmake_minimum_required(VERSION 3.16)
project(check C CXX)
find_package(clearway REQUIRED)
add_executable(cmake-c $here/examples/plan.c)
target_link_libraries(cmake-c clearway::clearway)
add_executable(cmake-static $here/examples/plan.cpp)
target_compile_features(cmake-static PRIVATE cxx_std_17)
target_link_libraries(cmake-static clearway::static)
CMAKE
    cmake -S "$folder/cmake" -B "$folder/cmake/built" -DCMAKE_PREFIX_PATH="$folder/usr" >/dev/null
    cmake --build "$folder/cmake/built" >/dev/null
    mv "$folder"/cmake/built/cmake-c "$folder"/cmake/built/cmake-static "$folder"
fi

"${compilers[-1]%% *}" -std=gnu11 -Wall -Wextra -Werror -fsanitize=address,undefined -g "$here/tests/life.c" \
    "${flags[@]}" -lpthread -o "$folder/life"
for test in life fields; do
    "${compilers[-1]##* }" -std=c++17 -Wall -Wextra -Wpedantic -Werror -fsanitize=address,undefined -g "$here/tests/$test.cpp" \
        "${flags[@]}" -o "$folder/$test++"
done

fail() { echo "check.sh: $*" >&2; exit 1; }
export CLEARWAY_JSON=1
plan=("$folder"/c-* "$folder"/c++-* "$folder"/sanitized-* "$folder"/static)
[ ! -e "$folder/cmake-c" ] || plan+=("$folder/cmake-c" "$folder/cmake-static")

for program in "${plan[@]}"; do
    "$program" "$scenes/drive-a.json" check 2>"$folder/said" && fail "$program plans without a planner"
    grep -q "no planner runs in domain check" "$folder/said" || fail "$program: $(cat "$folder/said")"
done
"$programs/planner" --domain check 2>"$folder/planner.log" &
planner=$!
trap 'kill "$planner" 2>/dev/null || true; wait "$planner" 2>/dev/null || true' EXIT
for _ in $(seq 500); do grep -q ready "$folder/planner.log" && break; sleep 0.02; done
compared=0
for scene in "$scenes"/*.json; do
    [ "${scene##*/}" != drive-office.json ] || continue # needs a map
    "$programs/plan" --local --format json "$scene" >"$folder/expected"
    for program in "${plan[@]}"; do
        "$program" "$scene" check >"$folder/found" || fail "$program $scene"
        cmp "$folder/expected" "$folder/found" || fail "$program answers ${scene##*/} otherwise"
        compared=$((compared + 1))
    done
done

# Every field that clearway.hpp hands out is that of the reply.
python3 - "$scenes" >"$folder/scenes.jsonl" <<'PYTHON'
import json, pathlib, sys
for path in sorted(pathlib.Path(sys.argv[1]).glob("*.json*")):
    if path.suffix == ".jsonl":
        print(path.read_text().strip())
    elif path.name != "drive-office.json":  # needs a map
        scene = json.loads(path.read_text())
        print(json.dumps(scene | ({"report": "full"} if scene["task"] == "drive" else {})))
PYTHON
"$programs/plan" --local --format json - <"$folder/scenes.jsonl" >"$folder/expected" || [ $? = 1 ] # some are refused
"$folder/fields++" "$folder/scenes.jsonl" check >"$folder/found" || fail "fields"
python3 - "$folder/expected" "$folder/found" <<'PYTHON'
import itertools, json, sys
names = set()
def fields(reply):
    for name, value in reply.items():
        names.add(name)
        for entry in value if isinstance(value, list) else [value]:
            if isinstance(entry, dict):
                fields(entry)
expected, found = ([json.loads(line) for line in open(path)] for path in sys.argv[1:])
for number, (expected, found) in enumerate(itertools.zip_longest(expected, found), 1):
    if "error" in expected:
        expected.pop("id", None)  # C says it where there is a reply
    fields(expected)
    if expected != found:
        sys.exit(f"check.sh: fields of reply {number}: {expected}\nC++ has: {found}")
missing = {"exceeds", "stops", "exit", "channels", "bound", "rung", "junction", "needs", "least"} - names
if missing:
    sys.exit(f"check.sh: no reply has {missing}")
PYTHON
for program in "$folder"/c-gcc "$folder"/c++-gcc; do
    valgrind --quiet --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite \
        "$program" "$scenes/disassemble.json" check >"$folder/found" || fail "valgrind: $program"
    echo '{"task": "drive"}' >"$folder/bad.json"
    "$program" "$folder/bad.json" check 2>"$folder/said" && fail "$program takes a bad scene"
    grep -q "invalid_scene" "$folder/said" || fail "$program: $(cat "$folder/said")"
done
kill "$planner"
wait "$planner" 2>/dev/null || true

# Threads, forks, two processes; planners and clients that are killed.
serve() {
    "$programs/planner" --domain check --unsupervised 2>"$folder/planner.log" &
    planner=$!
    for _ in $(seq 500); do grep -q ready "$folder/planner.log" && return; sleep 0.02; done
    fail "the planner does not start: $(cat "$folder/planner.log")"
}
clients() { "$programs/plan" --list --format json | sed -n 's/.*"domain":"check".*"clients":\([0-9]*\).*/\1/p'; }
awk 'BEGIN {
    printf "{\"task\":\"drive\",\"start\":{\"position\":[0.75,0.75],\"heading\":0},\"goal\":{\"position\":[150.25,150.25]},"
    printf "\"body\":{\"footprint\":{\"width\":0.4,\"length\":0.6}},\"free_space\":{\"bounds\":{\"min\":[0,0],\"max\":[151,151]},\"solids\":["
    for (i = 0; i < 2500; i++) { x = 3 * int(i / 50) + 1.5; y = 3 * (i % 50) + 1.5
        printf "%s{\"box\":{\"min\":[%g,%g],\"max\":[%g,%g]}}", i ? "," : "", x, y, x + 1, y + 1 }
    printf "]},\"clearance\":{\"each\":["
    for (i = 0; i < 9999; i++) printf "%s%.6f", i ? "," : "", 0.1 + i * 1e-6
    printf "]}}" }' >"$folder/endless.json"
life() { "$folder/life" "$1" check "$scenes/drive-a.json" "$folder/endless.json"; }
serve
life threads || fail "threads"
life forks || fail "forks"
life threads & first=$!
life threads || fail "two processes"
wait "$first" || fail "two processes"

coproc client { exec "$folder/life" hangs check "$scenes/drive-a.json" "$folder/endless.json"; }
hangs=$client_PID
read -r _ <&"${client[0]}"
kill -9 "$hangs"
wait "$hangs" 2>/dev/null || true
for _ in $(seq 300); do [ "$(clients)" != 0 ] || break; sleep 0.1; done
[ "$(clients)" = 0 ] || fail "a client that was killed is still there: $(clients)"
life forks || fail "after a client was killed"

"$folder/life++" owners check "$scenes/drive-a.json" "$folder/endless.json" || fail "owners"

for life in life life++; do
    coproc client { exec "$folder/$life" killed check "$scenes/drive-a.json" "$folder/endless.json"; }
    waits=$client_PID
    exec {from}<&"${client[0]}" {to}>&"${client[1]}"
    read -r _ <&"$from"
    kill -9 "$planner"
    wait "$planner" 2>/dev/null || true
    read -r _ <&"$from" || fail "$life: a killed planner"
    serve
    echo >&"$to"
    wait "$waits" || fail "$life: after a killed planner"
    exec {from}<&- {to}>&-
done
kill "$planner"
wait "$planner" 2>/dev/null || true

# A planner that lies is an error, and no memory is read that is not there.
tell() {
    coproc liar { exec "$programs/raw-planner" "lie-$1" "$1"; }
    planner=$liar_PID
    read -r _ <&"${liar[0]}"
    for program in "${plan[@]}"; do
        "$program" "$scenes/drive-a.json" "lie-$1" >/dev/null 2>"$folder/said" && fail "$program believes $1"
        grep -q "$2" "$folder/said" || fail "$program, $1: $(cat "$folder/said")"
    done
    kill "$planner"
    wait "$planner" 2>/dev/null || true
    rm -rf "/dev/shm/cw_raw$(printf %05d $((planner % 100000)) | tr 0-9 a-j)_"* "$CLEARWAY_ROOT"
}
tell layout "another layout of version 2"
tell version "version is 99"
tell truncated "samples needs 900 cells, 9 are left"
tell trailing "9 cells follow"
tell elements "claims 1099511627776 cells"
echo "check.sh: $compared replies compared"
