#!/bin/sh
# A sweep as a job array on a real Slurm of one node, on Debian, as root:
#
#     apt-get install slurm-wlm munge
#     cargo build --release
#     tests/cluster/slurm.sh
#
# The script starts munge and a Slurm of its own on this machine, submits the array that
# `clastic sweep --emit slurm` prints, kills a task, queues it again, and compares every result with
# those of a sweep without Slurm. It stops what it started. Exit code 0: all files are equal.
set -eu

root=$(cd "$(dirname "$0")/../.." && pwd)
program=${CLASTIC:-$root/target/release/clastic}
[ -x "$program" ] || { echo "no $program; build it: cargo build --release"; exit 2; }
for tool in munged slurmctld slurmd sbatch squeue scontrol scancel; do
    command -v "$tool" >/dev/null || { echo "no $tool; install slurm-wlm and munge"; exit 2; }
done
[ "$(id -u)" = 0 ] || { echo "Slurm needs root to start"; exit 2; }

work=$(mktemp -d -t clastic_slurm.XXXXXX)
host=$(hostname -s)
export SLURM_CONF="$work/slurm.conf"
stop() {
    scancel --user=root 2>/dev/null || true
    for name in slurmd slurmctld munged; do
        [ -f "$work/$name.pid" ] || continue
        pid=$(cat "$work/$name.pid")
        kill "$pid" 2>/dev/null || true
        while kill -0 "$pid" 2>/dev/null; do sleep 0.1; done
    done
}
trap stop EXIT

# Waits until a command succeeds, at most five minutes.
wait_for() {
    for _ in $(seq 600); do
        "$@" >/dev/null 2>&1 && return 0
        sleep 0.5
    done
    echo "waited in vain for: $*"
    tail -n 5 "$work"/*.log
    exit 1
}

# Munge: a key and a socket of our own.
dd if=/dev/urandom of="$work/munge.key" bs=1024 count=1 2>/dev/null
chmod 700 "$work"
chmod 400 "$work/munge.key"
munged --force --num-threads=2 --key-file="$work/munge.key" --socket="$work/munge.socket" \
    --pid-file="$work/munged.pid" --log-file="$work/munged.log" --seed-file="$work/munge.seed"

mkdir "$work/state" "$work/spool"
cat >"$SLURM_CONF" <<CONF
ClusterName=clastic
SlurmctldHost=$host(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$work/munge.socket
CredType=cred/munge
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_interval=1
MpiDefault=none
ReturnToService=2
SlurmctldPort=16817
SlurmdPort=16818
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$host Default=YES MaxTime=INFINITE State=UP
CONF
slurmctld
slurmd
node_is_idle() { [ "$(sinfo -h -o %t)" = idle ]; }
wait_for node_is_idle

# A study whose runs take some seconds each, so that a task can be killed.
cat >"$work/study.ron" <<'STUDY'
(
    version: 1,
    title: "two packings, two pressures each",
    scene: "rig.ron",
    settings: { "confining": ["let.confining"], "seed": ["let.seed"] },
    runs: Grid({ "confining": [50.0e3, 100.0e3], "seed": [1, 2] }),
)
STUDY
"$program" new biaxial >"$work/rig.ron"
cd "$work"
"$program" sweep study.ron --out local --quiet >/dev/null

PATH="$(dirname "$program"):$PATH"
export PATH
clastic sweep study.ron --out cluster --emit slurm >array.sh
job=$(sbatch --parsable array.sh)
echo "submitted: job $job, $(grep -c '^# [0-9]*:' array.sh) tasks"
# The first task is killed in the middle, without a chance to tidy up, and queued again.
is_under_way() { ls cluster/*/checkpoint.bin; }
wait_for is_under_way
scancel --signal=KILL --full "${job}_1"
is_gone() { ! squeue -h -j "${job}_1" -t RUNNING | grep -q .; }
wait_for is_gone
scontrol requeue "${job}_1"
echo "task 1 killed and queued again; Slurm begins it after two minutes"
is_over() { [ -z "$(squeue -h)" ]; }
wait_for is_over
clastic sweep study.ron --out cluster --collect

# Every result is equal. Timings are measurements, and checkpoints are there only after a kill.
differences=0
for directory in local/*/; do
    name=$(basename "$directory")
    for file in $(cd "$directory" && find . -type f ! -name 'timings*' ! -name '*checkpoint*'); do
        cmp "local/$name/$file" "cluster/$name/$file" || differences=$((differences + 1))
    done
done
cmp local/study.csv cluster/study.csv || differences=$((differences + 1))
[ "$differences" = 0 ] || { echo "$differences files differ; they are in $work"; exit 1; }
echo "all files of $(ls -d local/*/ | wc -l) runs equal"
stop
trap - EXIT
rm -rf "$work"
