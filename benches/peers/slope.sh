#!/usr/bin/env bash
# The LiDAR chain and the same chain of PCL's parts on one sweep, one after the other, one thread each.
#
#   benches/peers/slope.sh [CLOUD.pcd] [RUNS]
#
# Needs PCL 1.12 or later (Debian: libpcl-dev) and g++. Without a cloud the simulator takes one of the ramp of 15.3°.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$(cd "$here/../.." && pwd)"
out=$root/out/peers
runs=${2:-21}
mkdir -p "$out"
cloud=${1:-$out/lidar/slope-15.3.pcd}
if [ $# -lt 1 ]; then
  cargo run -q --release --manifest-path "$root/Cargo.toml" -p scandent-scenes --example make_lidar "$out/lidar" >/dev/null
fi
parts=(common io filters search kdtree segmentation sample_consensus)
# Only one of the folders is there: `ls` fails on the other.
include=$(ls -d /usr/include/pcl-* /usr/local/include/pcl-* 2>/dev/null | tail -1 || true)
if [ -z "$include" ]; then
  echo "no PCL in /usr/include or /usr/local/include" >&2
  exit 1
fi
# Without -march=native: the libraries of the distribution are built without it, and Eigen's alignment is part of
# the interface.
g++ -O3 -std=c++17 -I"$include" -I/usr/include/eigen3 "$here/slope_pcl.cpp" -o "$out/slope_pcl" \
  "${parts[@]/#/-lpcl_}" -lboost_system
export OMP_NUM_THREADS=1
"$out/slope_pcl" "$cloud" "$runs"
SCANDENT_CLOUD=$(realpath "$cloud") cargo bench -q --manifest-path "$root/Cargo.toml" -p scandent-perception --bench lidar 2>/dev/null \
  | grep "whole chain"
