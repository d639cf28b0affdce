# syntax=docker/dockerfile:1
# The gateway and the dashboard it serves: no numerics inside.
#   docker build -f deploy/docker/gateway.Dockerfile -t shapery-gateway .

FROM node:24-bookworm-slim AS dashboard
WORKDIR /src/services/dashboard
COPY services/dashboard/package.json services/dashboard/package-lock.json services/dashboard/.npmrc ./
RUN npm ci --no-fund --no-audit
COPY api_schema /src/api_schema
COPY services/dashboard ./
RUN npm run build

FROM python:3.12-slim-bookworm AS build
ENV PIP_NO_CACHE_DIR=1 PIP_DISABLE_PIP_VERSION_CHECK=1
RUN python -m venv /opt/shapery
ENV PATH=/opt/shapery/bin:$PATH
COPY deploy/locks/gateway.lock /src/
RUN pip install --require-hashes -r /src/gateway.lock
RUN python -m venv /opt/build && /opt/build/bin/pip install "hatchling>=1.27"
COPY shared/contracts /src/shared/contracts
COPY shared/platform /src/shared/platform
COPY services/gateway /src/services/gateway
COPY --from=dashboard /src/services/gateway/shapery_gateway/static /src/services/gateway/shapery_gateway/static
RUN for member in shared/contracts shared/platform services/gateway; do \
        /opt/build/bin/hatchling build -t wheel -d /wheels "/src/$member" || exit 1; \
    done; \
    pip install --no-deps /wheels/*.whl

FROM python:3.12-slim-bookworm
LABEL org.opencontainers.image.title="shapery-gateway" org.opencontainers.image.licenses="Apache-2.0"
RUN useradd --system --uid 10001 --no-create-home --shell /usr/sbin/nologin shapery
COPY --from=build /opt/shapery /opt/shapery
ENV PATH=/opt/shapery/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    PYTHONDONTWRITEBYTECODE=1 \
    SHAPERY_PROFILE=production \
    SHAPERY_HOST=0.0.0.0 \
    SHAPERY_PORT=8000 \
    SHAPERY_SCRATCH=/tmp
USER 10001
EXPOSE 8000
# The root file system may be mounted read-only; only /tmp is written to.
HEALTHCHECK --interval=10s --timeout=3s --start-period=20s --retries=3 \
    CMD ["python", "-c", "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8000/healthz', timeout=2)"]
CMD ["python", "-m", "shapery_gateway"]
