# The game server in a small image: built in one stage, only what runs in the other. It works with a read-only
# root and a /tmp in memory. Films as MP4 need `--build-arg EXTRAS=server,certify,postgres,redis,video`.
# A tag may be moved to another image, a digest never. To build on one digest only, look it up once,
#   docker buildx imagetools inspect --format '{{.Manifest.Digest}}' python:3.13.9-slim-trixie
# and build with `--build-arg DIGEST=@sha256:…`.
ARG DIGEST=
FROM python:3.13.9-slim-trixie${DIGEST} AS build
ARG EXTRAS=server,certify,postgres,redis
WORKDIR /src
# The dependencies come first: a change of the source does not install them again.
COPY pyproject.toml constraints.txt README.md LICENSE ./
COPY engine/__init__.py engine/
# Without tests and symbols for debuggers, the packages have 231 MB instead of 260.
RUN mkdir -p src/plinko app static && touch src/plinko/__init__.py \
 && python -m venv --without-pip /opt/plinko \
 && pip --python /opt/plinko/bin/python install --no-cache-dir -c constraints.txt ".[$EXTRAS]" \
 && find /opt/plinko -type d -name tests -prune -exec rm -r {} + \
 && apt-get update && apt-get install --yes --no-install-recommends binutils \
 && find /opt/plinko -name '*.so' -not -path '*.libs/*' -exec strip --strip-debug {} +
COPY engine engine
COPY app app
COPY src src
COPY static static
RUN pip --python /opt/plinko/bin/python install --no-cache-dir --no-deps --force-reinstall .

FROM python:3.13.9-slim-trixie${DIGEST}
RUN pip uninstall --yes --root-user-action ignore pip \
 && rm -r /usr/local/lib/python3.13/ensurepip \
 && useradd --uid 10001 --no-create-home --shell /usr/sbin/nologin plinko \
 && install -d -o plinko -m 0700 /var/lib/plinko
COPY --from=build /opt/plinko /opt/plinko
ENV PATH=/opt/plinko/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    PLINKO_DATA=/var/lib/plinko
USER plinko
EXPOSE 8000
# The ledger: what was dropped and how it ended, and the secret that signs rooms' tokens.
VOLUME /var/lib/plinko
# By bash, because a Python takes a tenth of a second each time.
HEALTHCHECK --interval=30s --timeout=3s --start-period=60s \
  CMD ["bash", "-c", "exec 3<>/dev/tcp/127.0.0.1/8000 && printf 'GET /healthz HTTP/1.1\\r\\nHost: localhost\\r\\nConnection: close\\r\\n\\r\\n' >&3 && grep -q '^HTTP/1.1 200 ' <&3"]
CMD ["plinko", "serve", "--host", "0.0.0.0"]
