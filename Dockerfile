# The suite with its packages, on the CPU: docker build -t active-view-selection . ; docs/cluster.md says how it is run.
FROM python:3.11-slim-bookworm

# make and git: the Makefile, and the revision in records. The libraries: what Open3D's and OpenCV's wheels expect of a system.
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install --yes --no-install-recommends \
        git libegl1 libgl1 libgomp1 libudev1 libusb-1.0-0 libx11-6 make \
    && rm -rf /var/lib/apt/lists/*

WORKDIR /suite
# The packages first: a change of the code does not install them anew.
COPY Makefile environment.txt ./
RUN make PYTHON=python3 .venv/installed

COPY . .
ENV PATH=/suite/.venv/bin:$PATH
ENTRYPOINT ["snakemake"]
CMD ["-j2", "tables"]
