# Figures, from records and what lies beside them.


rule psnr_over_views:
    input:
        episodes=all_episodes,
        settings=f"{RESULTS}/settings/psnr_over_views.json",
        code=sources("avs.report.figures.psnr_over_views"),
    output:
        multiext(f"{RESULTS}/figures/psnr_over_views", ".pdf", ".png"),
    log:
        f"{LOGS}/figures/psnr_over_views.log",
    params:
        made_of=made_of,
        stem=subpath(output[0], strip_suffix=".pdf"),
    message:
        "figure: PSNR over views"
    shell:
        "{AVS} --made-of {params.made_of} psnr_over_views"
        " {input.episodes} --settings {input.settings} --out {params.stem} --log {log}"


rule figures:
    input:
        f"{RESULTS}/figures/psnr_over_views.pdf",
        coverage_figures,
