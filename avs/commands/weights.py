"""Commands that list, fetch and check pretrained weights from elsewhere."""

from __future__ import annotations

from typing import Annotated

import typer

from avs.system.job_process import job

HELP = "Pretrained weights from elsewhere: list, fetch, check."

commands = typer.Typer(no_args_is_help=True, help=HELP)


@commands.command("list")
def list_weights() -> None:
    """List the pretrained weights: source, size, licence, the methods that use them, whether they are here."""
    with job(None):
        from avs.system.weights.inventory import listing

        print("\n".join(listing()))


@commands.command("fetch")
def fetch_weights(names: Annotated[list[str], typer.Argument(help="names that `avs weights list` shows")]) -> None:
    """Download pretrained weights into the cache folder and verify them; the only command that uses the network."""
    with job(None):
        from avs.system.weights.download import fetch

        for name in names:
            fetch(name, print)


@commands.command("check")
def check_weights(
    names: Annotated[list[str] | None, typer.Argument(help="weights that must be here; default: all that are")] = None,
) -> None:
    """Compare the weights on this machine with the manifest, and read them; exit status 2 if one is bad."""
    with job(None):
        from avs.system.weights.inventory import check

        check(names or [], print)
