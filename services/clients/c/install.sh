#!/usr/bin/env bash
# Builds libclearway and installs it with its headers, pkg-config file and CMake package:
# install.sh PREFIX [PROFILE]. Needs Rust; the profile is `release` by default.
set -euo pipefail
[ $# -ge 1 ] || { echo "usage: install.sh PREFIX [PROFILE]" >&2; exit 2; }
prefix=$(realpath -m "$1")
profile=${2:-release}
cd "$(dirname "$0")"
cargo build --quiet --locked --package clearway-c --profile "$profile"
target=$(cargo metadata --format-version 1 --no-deps --locked |
    sed 's/.*"target_directory":"\([^"]*\)".*/\1/')
version=$(cargo pkgid --locked --package clearway-c | sed 's/.*[@#]//')
built=$target/$([ "$profile" = dev ] && echo debug || echo "$profile")
install -d "$prefix/include" "$prefix/lib/pkgconfig" "$prefix/lib/cmake/clearway"
install -m 644 include/clearway.h include/clearway.hpp "$prefix/include"
install -m 644 "$built/libclearway.so" "$built/libclearway.a" "$prefix/lib"
install -m 644 cmake/clearway-config.cmake "$prefix/lib/cmake/clearway"
sed -e "s|@PREFIX@|$prefix|" -e "s|@VERSION@|$version|" clearway.pc.in >"$prefix/lib/pkgconfig/clearway.pc"
