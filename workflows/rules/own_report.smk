# What Snakemake's own report holds (snakemake --report): tables and figures in categories, with captions.

from snakemake.io import ReportObject

from avs.report.page.figure_places import figure_place
from avs.report.page.table_facts import table_place


def told_of_output(path):
    """Return the caption, the section and the labels of an output in the report, or None where it is not in it."""
    if path.parent == Path(f"{RESULTS}/tables") and path.suffix == ".csv":
        section, title = table_place(path.stem)
        return "table", section, {"table": title}
    if path.parent == Path(f"{RESULTS}/figures") and path.suffix in (".png", ".gif"):
        section, title, text = figure_place(path.stem)
        return "figure", section, {"figure": title, "shows": text}
    return None


def mark_outputs():
    """Mark the outputs of all rules that belong into the report."""
    for each in workflow.rules:
        for output in each.output:
            told = told_of_output(Path(str(output)))
            if told is not None:
                caption, section, labels = told
                source = workflow.current_basedir.join(f"../report/{caption}.rst")
                output.flags["report"] = ReportObject(
                    source, section, None, labels, [], None
                )


mark_outputs()
