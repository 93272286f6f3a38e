# Everyday commands; `just` lists them. Each is a line of shell that runs as well without just.

# List the commands
default:
    @just --list

# Plan the scene that ships into out/ and say where the page to look at lies
demo:
    cargo run --release
    @echo "open out/irregular-stairs/view.html"

# Format, lint and test as CI does, from a clean checkout
ci:
    .ci/run

# Formatting and lints
lint:
    cargo fmt --all
    cargo clippy --workspace --all-targets -- -D warnings

# The quick tests: everything but the modules named `slow`, in a minute and a half once built
test *ARGS:
    scripts/test quick {{ARGS}}

# Every test, the slow ones and the physics simulation too
test-all *ARGS:
    scripts/test {{ARGS}}

# The documentation of all crates, without warnings
doc:
    RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps

# What must not get worse, beside another built program (or an earlier record's JSON)
record OTHER="docs/record/2026-11-before.json" *ARGS="":
    scripts/fetch-mujoco
    cargo build --release --features mujoco
    cargo run --release -p scandent-record --bin record -- --program target/release/scandent --against {{OTHER}} {{ARGS}}

# Times of the pipeline's stages and of postures, by criterion
bench *ARGS:
    cargo bench {{ARGS}}

# Take the scans of the scenes that ship again, after a change of geometry, noise or pose
scans:
    cargo run --release -p scandent-scenes --example make_scans

# Build the viewer's page after a change of its sources
viewer:
    cd viewer && npm ci && npm run build

# What a release publishes, in target/dist; publishes nothing
package *ARGS:
    scripts/package {{ARGS}}
