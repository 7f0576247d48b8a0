# The game server in a small image: wheels built in one stage, only what runs in the other.
FROM python:3.11-slim AS build
WORKDIR /src
COPY pyproject.toml constraints.txt README.md LICENSE ./
COPY engine engine
COPY app app
COPY static static
RUN python -m venv /opt/plinko \
 && /opt/plinko/bin/pip install --no-cache-dir -c constraints.txt '.[postgres]'

FROM python:3.11-slim
RUN useradd --uid 10001 --no-create-home --shell /usr/sbin/nologin plinko
COPY --from=build /opt/plinko /opt/plinko
ENV PATH=/opt/plinko/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    PLINKO_DATA=/var/lib/plinko \
    NUMBA_CACHE_DIR=/var/cache/plinko
# Machine code is compiled here, by the user that runs it, so that a container starts at once. On
# a processor that lacks what the builder's has it is compiled again at the first start.
RUN install -d -o plinko /var/cache/plinko && install -d -o plinko -m 0700 /var/lib/plinko
USER plinko
RUN plinko simulate triangle-8 --drops 10 \
 && plinko simulate triangle-8 --drops 10 --solver stepped \
 && plinko render triangle-8 --seed 42 /tmp/drop.gif \
 && plinko render triangle-8 --density 10 /tmp/density.png \
 && rm /tmp/drop.gif /tmp/density.png
RUN PLINKO_DATABASE_URL=sqlite:// plinko serve & server=$!; \
    until python -c "import urllib.request as u; u.urlopen('http://127.0.0.1:8000/readyz')" 2>&-; \
    do sleep 1; done; \
    kill $server; wait $server
EXPOSE 8000
# The ledger: what was dropped and how it ended, and the secret that signs rooms' tokens.
VOLUME /var/lib/plinko
HEALTHCHECK --interval=30s --timeout=3s --start-period=60s \
  CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8000/healthz', timeout=2)"]
CMD ["plinko", "serve", "--host", "0.0.0.0"]
