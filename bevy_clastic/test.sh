#!/usr/bin/env bash
# Tests the window under a display of its own, with a graphics driver in software. Screenshots go to
# screenshots/. On Debian:
#   apt-get install pkg-config libx11-dev libxcursor1 libxi6 libxrandr2 libxkbcommon-x11-0 xvfb mesa-vulkan-drivers
set -euo pipefail
cd "$(dirname "$0")"
driver=${CLASTIC_VULKAN_DRIVER:-/usr/share/vulkan/icd.d/lvp_icd.x86_64.json}
[[ -f $driver ]] || { echo "no driver $driver: install mesa-vulkan-drivers" >&2; exit 1; }
export VK_ICD_FILENAMES=$driver WGPU_BACKEND=vulkan
cargo fmt --check
# The sample of the README is the example.
diff <(sed -n '/^```rust$/,/^```$/p' README.md | sed '1d;$d') examples/sprites.rs
# Bevy with its renderer asks for Rust 1.97, and 1.95 compiles it.
cargo clippy --ignore-rust-version --all-targets -- -D warnings
RUSTDOCFLAGS='-D warnings' cargo doc --ignore-rust-version --no-deps
xvfb-run --auto-servernum --server-args='-screen 0 1400x1000x24' cargo test --ignore-rust-version "$@"
