#!/usr/bin/env bash
# Times a round trip through each client, by turns, in one run, beside iceoryx2 alone, a Unix-domain socket
# with pickled numpy and, if PYTHON has ROS 2, GetPlan between two processes: round_trip.sh PYTHON [PROFILE],
# where PYTHON has the package clearway of the same profile (`release` by default). Needs a C++ compiler.
set -euo pipefail
[ $# -ge 1 ] || { echo "usage: round_trip.sh PYTHON [PROFILE]" >&2; exit 2; }
python=$(realpath --no-symlinks "$1")
profile=${2:-release}
cd "$(dirname "$0")/../.."
folder=$(mktemp -d)
export CLEARWAY_ROOT=$folder/root
cargo build --quiet --locked --profile "$profile" -p clearway-planner --bin planner
cargo build --quiet --locked --profile "$profile" -p clearway-client --example round_trip
services/clients/c/install.sh "$folder/usr" "$profile"
built=target/$([ "$profile" = dev ] && echo debug || echo "$profile")
c++ -std=c++17 -O2 services/clients/c/examples/round_trip.cpp -I"$folder/usr/include" \
    -L"$folder/usr/lib" -lclearway -Wl,-rpath,"$folder/usr/lib" -o "$folder/cpp"
trap 'kill "$planner" 2>/dev/null; wait "$planner" 2>/dev/null || true; rm -rf "$folder"' EXIT
"$built/planner" --domain bench 2>"$folder/log" &
planner=$!
for _ in $(seq 500); do grep -q ready "$folder/log" && break; sleep 0.02; done
for samples in 100 1000; do
    sed "s/\"sampling\": *{[^}]*}/\"sampling\": {\"count\": $samples}/; s/\"clearance\": *{[^}]*}/\"clearance\": {\"gap\": 0.2}/" \
        recordings/scenes/disassemble-channels.json >"$folder/scene.json"
    for round in 1 2 3; do
        echo "$samples samples, round $round; median and 99 %, us: load $(cut -d' ' -f1 /proc/loadavg)"
        echo "  Rust            $("$built/examples/round_trip" "$folder/scene.json" bench 5000)"
        echo "  C++             $("$folder/cpp" "$folder/scene.json" bench 5000)"
        for form in prepared dict; do
            printf '  Python %-8s %s\n' "$form" \
                "$("$python" services/clients/python/examples/round_trip.py "$folder/scene.json" bench 5000 "$form")"
        done
        echo "  socket, pickle  $("$python" services/clients/python/examples/socket_round_trip.py "$folder/scene.json" "$samples" 5000)"
        if "$python" -c 'import rclpy' 2>/dev/null; then
            echo "  GetPlan, rclpy  $("$python" services/clients/ros/test/round_trip.py "$samples" 500)"
        fi
    done
done
# By polling alone, with the same payloads.
[ "$profile" != release ] || cargo bench --quiet --locked -p integration-tests --bench round_trip
