# docker build -t scandent . && docker run --rm -v "$PWD:/work" scandent plan --scan stairs_depth.png … -o out
FROM rust:1.95-slim-bookworm AS built
WORKDIR /scandent
COPY . .
RUN cargo build --release --locked --config profile.release.strip=true

FROM debian:bookworm-slim
COPY --from=built /scandent/target/release/scandent /usr/local/bin/
COPY LICENSE-MIT LICENSE-APACHE /usr/share/doc/scandent/
RUN useradd --create-home scandent && mkdir /work && chown scandent /work
USER scandent
WORKDIR /work
ENTRYPOINT ["scandent"]
