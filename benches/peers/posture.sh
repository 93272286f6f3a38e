#!/usr/bin/env bash
# Solves one set of posture problems with Scandent, Drake and Klampt, each on one thread, and audits all answers.
#
#   benches/peers/posture.sh talos|hrp2 PROBLEMS.json [FOLDER]
#
# Needs the release binary (cargo build --release, or SCANDENT=path) and, for talos, scripts/fetch-robots. The peers live
# in a virtual environment of third_party/, which is made on the first run.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
root="$(cd "$here/../.." && pwd)"
robot=${1:?talos or hrp2}
problems=${2:?a file of problems, as scandent posture-sets writes it}
out=${3:-$root/out/peers}
scandent=${SCANDENT:-${CARGO_TARGET_DIR:-$root/target}/release/scandent}

case $robot in
talos)
  data=$root/third_party/example-robot-data/robots/talos_data
  urdf=$data/robots/talos_reduced.urdf srdf=$data/srdf/talos.srdf
  ;;
*)
  urdf=$root/scenes/robots/$robot/$robot.urdf srdf=$root/scenes/robots/$robot/$robot.srdf
  ;;
esac
contacts=$root/scenes/robots/$robot/contacts.toml

venv=$root/third_party/peers
if [ ! -x "$venv/bin/python" ]; then
  python3 -m venv "$venv"
fi
"$venv/bin/python" -m pip install -q -r "$here/requirements.txt"

mkdir -p "$out"
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1
# Every solver may use the whole of friction and torque; Scandent is run with its planning margins, too.
whole=(--set posture.friction_use=1 --set posture.torque_use=1 --set posture.com_margin_m=0
  --set posture.joint_margin_rad=0)
files=(--robot "$urdf" --srdf "$srdf" --contacts "$contacts")
"$scandent" posture "$problems" "${files[@]}" --repeat 5 -o "$out/scandent.json" >/dev/null
"$scandent" posture "$problems" "${files[@]}" --repeat 5 "${whole[@]}" -o "$out/scandent-whole.json" >/dev/null
for peer in klampt drake; do
  "$venv/bin/python" "$here/posture/${peer}_solve.py" --urdf "$urdf" --srdf "$srdf" --contacts "$contacts" \
    -o "$out/$peer.json" "$problems" 2>"$out/$peer.log" >/dev/null
done
"$venv/bin/python" "$here/audit.py" --urdf "$urdf" --srdf "$srdf" --contacts "$contacts" --faults "$out/faults.json" \
  "$problems" "scandent=$out/scandent.json" "scandent, no margins=$out/scandent-whole.json" \
  "klampt=$out/klampt.json" "drake=$out/drake.json"
