#!/usr/bin/env bash
# Installs libclearway, builds the examples as users would, and compares what they print with
# `plan --local`, under AddressSanitizer and valgrind too: check.sh FOLDER PROGRAMS, where PROGRAMS
# has `planner`, `plan` and `raw-planner`. Needs a C and a C++ compiler, pkg-config and valgrind; cmake if it is there.
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
    "$cxx" -std=c++17 -fno-exceptions -Werror -fsyntax-only "$here/examples/plan.cpp" "${flags[@]}"
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
trap 'kill "$planner" 2>/dev/null; wait "$planner" 2>/dev/null || true' EXIT
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
for program in "$folder"/c-gcc "$folder"/c++-gcc; do
    valgrind --quiet --error-exitcode=9 --leak-check=full --errors-for-leak-kinds=definite \
        "$program" "$scenes/disassemble.json" check >"$folder/found" || fail "valgrind: $program"
    echo '{"task": "drive"}' >"$folder/bad.json"
    "$program" "$folder/bad.json" check 2>"$folder/said" && fail "$program takes a bad scene"
    grep -q "invalid_scene" "$folder/said" || fail "$program: $(cat "$folder/said")"
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
