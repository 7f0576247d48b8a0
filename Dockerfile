# The game server in a small image: built in one stage, only what runs in the other. It has every part
# that deploy/compose.yaml starts, and works with a read-only root and a /tmp in memory.
FROM python:3.13.9-slim-trixie AS build
WORKDIR /src
COPY pyproject.toml constraints.txt README.md LICENSE ./
COPY engine engine
COPY app app
COPY src src
COPY static static
RUN python -m venv --without-pip /opt/plinko \
 && pip --python /opt/plinko/bin/python install --no-cache-dir -c constraints.txt \
      '.[server,certify,postgres,redis,batches,video]'

FROM python:3.13.9-slim-trixie
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
HEALTHCHECK --interval=30s --timeout=3s --start-period=60s \
  CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8000/healthz', timeout=2)"]
CMD ["plinko", "serve", "--host", "0.0.0.0"]
