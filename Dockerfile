# Isostrata in a container:
#
#   docker build -t isostrata .
#   docker run --rm -p 127.0.0.1:8080:8080 -v /path/to/fields:/data:ro isostrata /data
#
# and open the URL that it prints. Without a path it serves a built-in analytic field. deploy/prove-container runs these very commands.

FROM debian:bookworm-slim AS build
WORKDIR /src
# First only what decides which packages are installed: a change of a source then installs nothing again.
COPY deploy/packages.txt deploy/setup deploy/
RUN deploy/setup build page
COPY . .
RUN deploy/build && cmake --install build/release --prefix /opt/isostrata --strip

FROM debian:bookworm-slim
COPY deploy/packages.txt deploy/setup /tmp/isostrata/deploy/
RUN /tmp/isostrata/deploy/setup run && apt-get clean && rm -rf /tmp/isostrata /var/lib/apt/lists/*
RUN useradd --system --create-home --uid 10001 --shell /usr/sbin/nologin isostrata && install -d -o isostrata -m 700 /state
COPY --from=build /opt/isostrata/bin /usr/local/bin
COPY --from=build /opt/isostrata/lib/isostrata /usr/local/lib/isostrata
COPY --from=build /opt/isostrata/share /usr/local/share
COPY deploy/healthcheck /usr/local/bin/isostrata-healthcheck
# Asks NVIDIA's container runtime, where the machine has it, for the driver's EGL; without a GPU Mesa draws on the CPU.
ENV NVIDIA_DRIVER_CAPABILITIES=graphics,utility
# Sessions outlive the container in a volume (-v NAME:/state). Nothing else has to be written, so it runs --read-only --tmpfs /tmp.
ENV XDG_STATE_HOME=/state
ENV MESA_SHADER_CACHE_DISABLE=true
VOLUME /state
USER isostrata
WORKDIR /home/isostrata
EXPOSE 8080
HEALTHCHECK --interval=30s --timeout=5s --start-period=20s --retries=3 CMD ["isostrata-healthcheck"]
ENTRYPOINT ["isostrata", "serve", "--host", "0.0.0.0", "--port", "8080"]
