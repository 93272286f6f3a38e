#!/usr/bin/env bash
# Surfaces of the same depth frames by Scandent, by the chain of brossette2013 with PCL's parts, and by Open3D, each on
# one thread, one after the other, and a table of time, recall, precision, plane error and area off the faces.
#
#   benches/peers/surfaces.sh [FRAMES] [RUNS]
#
# FRAMES is a folder of frames with their truth (NAME_depth.png, NAME.pcd, NAME_gt.json and NAME_gt.bin or NAME_gt.npz);
# without one the simulator takes 18: three worlds, white and real noise, three seeds. Needs PCL 1.12 or later (Debian:
# libpcl-dev, libboost-system-dev), g++ and Python 3.9 to 3.12; Open3D comes from PyPI into third_party/.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$(cd "$here/../.." && pwd)"
out=${OUT:-$root/out/peers/surfaces}
frames=${1:-$out/frames}
runs=${2:-5}
mkdir -p "$out"
cargo=(cargo run -q --release --manifest-path "$root/Cargo.toml")
if [ $# -lt 1 ]; then
  "${cargo[@]}" -p scandent-record --bin record -- --frames "$frames"
fi

venv=${VENV:-$root/third_party/peers-surfaces}
if [ ! -x "$venv/bin/python" ]; then
  python3 -m venv "$venv"
fi
"$venv/bin/python" -m pip install -q -r "$here/surfaces/requirements.txt"

# Only one of the folders is there: `ls` fails on the other.
include=$(ls -d /usr/include/pcl-* /usr/local/include/pcl-* 2>/dev/null | tail -1 || true)
if [ -z "$include" ]; then
  echo "no PCL in /usr/include or /usr/local/include" >&2
  exit 1
fi
parts=(common io_ply io filters features kdtree search segmentation sample_consensus surface)
# Without -march=native: the libraries of the distribution are built without it, and Eigen's alignment is part of
# the interface.
nice -n 10 g++ -O3 -std=c++17 -I"$include" -I/usr/include/eigen3 "$here/surfaces/pcl_chain.cpp" -o "$out/pcl_chain" \
  "${parts[@]/#/-lpcl_}" -lboost_system

export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 RAYON_NUM_THREADS=1
cargo build -q --release --manifest-path "$root/Cargo.toml" -p scandent-perception --example time_extraction
extract=${CARGO_TARGET_DIR:-$root/target}/release/examples/time_extraction
results=$out/results
rm -rf "$results"
mkdir -p "$results"/{pcl,organised,voxels}
for truth in "$frames"/*_gt.json; do
  stem=${truth%_gt.json}
  name=$(basename "$stem")
  "$out/pcl_chain" "$stem.pcd" "$results/pcl/$name" "$runs" >"$results/pcl/$name.log"
  # Runs that take about as long as PCL's, so that all have a processor as warm.
  for method_times in organised:100 voxels:5; do
    method=${method_times%:*}
    "$extract" "${stem}_depth.png" "$results/$method/$name" "$method" $((runs * ${method_times#*:}))
  done
done
"$venv/bin/python" "$here/surfaces/open3d_patches.py" "$frames" "$results/open3d" "$runs"
"$venv/bin/python" "$here/surfaces/score.py" "$frames" "$results" | tee "$out/table.md"
