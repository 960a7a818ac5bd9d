"""What the tests of the view synthesis table share: methods, published values, and a way to write a table."""

import csv

from avs.report.tables.view_synthesis import write_nvs_table

REFERENCE = "ours-repvit"
METHODS = ["random", "farthest", "piqe", "fisherrf", "ours-repvit"]
PUBLISHED = "table,dataset,scene,method,metric,value\n" + "".join(
    f"tab,mipnerf360,{scene},{method},{metric},{value}\n"
    for scene, method, metric, value in [
        ("mean", "random", "psnr", "17.91"),
        ("mean", "random", "ssim", "0.56"),
        ("mean", "ours-repvit", "psnr", "20.97"),
        ("garden", "ours-repvit", "psnr", "22.96"),
    ]
)


class TableWriter:
    """Writes tables of episodes into a folder."""

    def __init__(self, folder, written):
        self.folder = folder
        self.written = written

    def __call__(
        self,
        episodes,
        methods=METHODS,
        published=None,
        dataset="orbit",
        absent=None,
        reference=REFERENCE,
        left_out=None,
        pictures=None,
    ):
        """Write the table of some episodes; return its rows by (method, metric) and its Markdown and LaTeX."""
        if published is not None:
            (self.folder / "published.csv").write_text(published)
        source = None if published is None else self.folder / "published.csv"
        out = self.folder / "tables" / f"nvs_{dataset}"
        beside = (absent or {}, reference, left_out, pictures)
        write_nvs_table(self.written(episodes), methods, dataset, source, out, *beside)
        with open(f"{out}.csv", newline="") as stream:
            rows = {(row["method"], row["metric"]): row for row in csv.DictReader(stream)}
        return rows, *(out.with_name(out.name + ending).read_text() for ending in (".md", ".tex"))


def two_scenes(episode, method, offsets, **changes):
    """One episode a seed and scene: images of 20 + offset and 22 + offset in one scene, 10 dB more in the other."""
    return [
        episode(method, scene, seed, psnr=(base + offset, base + 2 + offset), **changes)
        for seed, offset in enumerate(offsets)
        for scene, base in (("attic", 20.0), ("cellar", 30.0))
    ]
