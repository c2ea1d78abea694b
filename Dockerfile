# docker build -t masonry-cd .
# docker run --rm -v "$PWD/out:/masonry_cd/out" masonry-cd                # the demo: out/demo/crack_map.png
# docker run --rm -v "$PWD:/scene" -w /scene masonry-cd masonry-cd run scene.toml -o out/scene

FROM python:3.12-slim

RUN apt-get update -qq \
 && apt-get install -y -qq --no-install-recommends make \
 && rm -rf /var/lib/apt/lists/*
WORKDIR /masonry_cd
COPY Makefile ./
RUN make libraries && rm -rf /var/lib/apt/lists/*
COPY . .
RUN make setup PYTHON=python3
ENV PATH="/masonry_cd/.venv/bin:$PATH"
CMD ["make", "demo"]
