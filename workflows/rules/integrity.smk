# Nothing stale and nothing damaged: what earlier runs left is checked before the plan is made, and what is not as it
# should be is made again. Files that are seen by readers are set aside until then.

from snakemake.dag import DAG
from snakemake.exceptions import WorkflowError
from snakemake.io import is_flagged
from snakemake.jobs import Job
from snakemake.persistence import PersistenceBase
from snakemake.utils import format as filled_in

from avs.config import gpu_memory
from avs.system.devices import smallest_gpu
from avs.system.job_command import digest_of_line
from avs.system.ledger import find_damage, origin_of
from avs.system.loaded_sources import write_sources
from avs.system.records import CHANGED

SET_ASIDE = f"{RESULTS}/set_aside"
UNLISTED = []  # logs of jobs of which nothing is known
SHOWN = [Path(f"{RESULTS}/tables"), Path(f"{RESULTS}/figures")]
INDEX = Path(PAGE, "index.html")
UNASKED = (
    {}
)  # what readers see and this run does not make, with all files that it is made from
REPORTED = []  # whether Snakemake's own report is asked for, which shows what is there
OLD = set()  # those of them that would be made again if they were asked for


def set_aside(path, fault):
    """Move a file or a folder out of the way, to the same path within another folder, and say why."""
    target = Path(SET_ASIDE, path.relative_to(RESULTS))
    target.parent.mkdir(parents=True, exist_ok=True)
    if path.is_dir():
        shutil.rmtree(target, ignore_errors=True)
    path.replace(target)
    print(f"{path}: {fault}; set aside as {target}", file=sys.stderr)


def outdated_settings():
    """Return the files of settings that are not what the configuration says; those of other runs are left out."""
    folder = Path(f"{RESULTS}/settings")
    found = []
    for path in folder.rglob("*.json"):
        job = path.relative_to(folder).with_suffix("").as_posix()
        try:
            told = record_text(settings_of(settings, job))
        except (LookupError, ValueError, UserError):
            continue  # of a method, a scene or a scorer that this run does not have
        if path.read_text(errors="replace") != told:
            found.append(path)
    return found


def shown_outputs():
    """Return all files that jobs write which make tables and figures of this configuration, for each target."""
    targets = [rule.input for rule in workflow.rules if not rule.output]
    return [files for target in targets if (files := shown_by(target))]


def shown_by(target):
    """Return those files for the inputs of one target."""
    makers = [
        (rule, path)
        for path in asked_for(target)
        for rule in workflow.rules
        if rule.is_producer(path)
    ]
    outputs = [rule.expand_output(rule.get_wildcards(path))[0] for rule, path in makers]
    return {
        Path(path) for each in outputs for path in each if Path(path).parent in SHOWN
    }


def is_shown(path):
    """Return whether readers look at a file: a table, a figure, or the page."""
    return path.parent in SHOWN or path == INDEX


def jobs_behind(path, dag, makers):
    """Return the jobs that make a file, itself and those behind it, each once; a file that no job makes has none.

    Args:
        path: of the file.
        dag: the jobs of this run.
        makers: the job that makes a file, by its path; those that are met are added, and None for files without.
    """
    waiting, behind = [path], {}
    while waiting:
        path = waiting.pop()
        if path not in makers:
            found = [each for each in workflow.rules if each.is_producer(path)]
            made_by = [
                Job(each, dag, each.get_wildcards(path), None, path)
                for each in found[:1]
            ]
            makers |= {str(each): job for job in made_by for each in job.output} or {
                path: None
            }
        job = makers[path]
        if job is not None and id(job) not in behind:
            behind[id(job)] = job
            waiting += map(str, job.input)
    return list(behind.values())


def find_unasked(dag):
    """Return the jobs behind each file that readers see and this run does not make, its own first.

    Args:
        dag: the jobs of this run.
    """
    makers = {str(path): job for job in dag.jobs for path in job.output}
    there = {path for folder in (*SHOWN, INDEX.parent) for path in folder.glob("*")}
    unasked = sorted(filter(is_shown, there - OUTSIDE - set(map(Path, makers))))
    return {path: jobs_behind(str(path), dag, makers) for path in unasked}


def told_of(job):
    """Return what a job is told of its sources: the stamp with its command behind it, and the files of other jobs."""
    stamp, *options = job.params.made_of
    command = getattr(job.params, "program", None)
    return f"{stamp} {command or digest_of_line(line_of(job))}", options[1::2]


def line_of(job):
    """Return the line that starts a job; ``job.shellcmd`` is for those alone that are in the plan."""
    names = ("input", "output", "params", "wildcards", "threads", "log")
    told = {name: getattr(job, name) for name in names}
    return filled_in(job.rule.shellcmd, AVS=AVS, **told)


def has_other_sources(job):
    """Return whether what a job would read is not what its last run read.

    Snakemake compares times, and what it keeps of code and parameters in .snakemake: a file that an older one replaces,
    as `cp -p`, `mv` or `rsync -a` leave it, is not newer than what was made from the one before; in a copy of a folder,
    all are as new.
    """
    if not hasattr(job.params, "made_of") or not job.log:
        return False
    told = origin_of(Path(job.log[0]))
    if told is None and any(Path(path).exists() for path in job.output):
        UNLISTED.append(job.log[0])
        if len(UNLISTED) == 1:
            print(
                f"{UNLISTED[0]}: no list beside it of what the job wrote and read, so that nothing can be checked; "
                "what it and others without one made is made again",
                file=sys.stderr,
            )
    return told is None or told.differs(*told_of(job))


def lift_rate_limit(scheduling):
    """Take away Snakemake 9.27's limit of 100 jobs a second, unless another one is given.

    For a limit its scheduler wakes once in the time span for every round that it has held, and asks each time for the
    size of every ready job's inputs: after 120 jobs that was half a core. Where the Snakefile is read, there are no
    settings of scheduling yet; no limit is needed where jobs take seconds.
    """
    limit = scheduling and scheduling.max_jobs_per_timespan
    if limit and (limit.max_jobs, limit.timespan) == (100, 1):
        scheduling.max_jobs_per_timespan = None


def tell_gpu_memory(workflow):
    """Tell what jobs will take of a GPU; refuse to run where there is none, unless they run elsewhere."""
    here = workflow.local_exec and not workflow.dryrun
    try:
        lines = gpu_memory.told(settings, smallest_gpu() if here else None)
    except UserError as error:
        raise WorkflowError(str(error))
    for line in lines:
        print(line, file=sys.stderr)


def refusing(check, look):
    """Return ``DAG.check_incomplete`` which looks first, and refuses to run without: old results would pass for current ones.

    It refuses to run on a device that is not here, too: each job's first act is to remove what an earlier run has made.
    """

    async def check_incomplete(self):
        lift_rate_limit(self.workflow.scheduling_settings)
        runs = self.workflow.execution_settings is not None
        if runs and settings.device == "cuda":
            tell_gpu_memory(self.workflow)
        given = {
            "--ignore-incomplete": self.ignore_incomplete,
            "--touch": runs and self.workflow.touch,
            "--allowed-rules": self.workflow.dag_settings.allowed_rules,
        }
        for option in [
            option for option, is_given in given.items() if runs and is_given
        ]:
            raise WorkflowError(
                f"{option}: would take results for current that are damaged, unfinished or of other code; leave it out"
            )
        if REPORTED:
            old = sorted(map(str, await self.incomplete_files()))
            if old:
                raise WorkflowError(
                    f"--report: would show results that are not current, as {old[0]}; run the same line without it first"
                )
        await look(self)
        await check(self)

    return check_incomplete


def check_results():
    """Find what is not as it should be, and let Snakemake take it for incomplete."""
    damage = find_damage(Path(LOGS))
    for each in damage:
        for path in each.changed:
            print(f"{path}: {CHANGED}; it is made again", file=sys.stderr)
    again = {
        path for each in damage for path in (*each.changed, *each.lacking, *each.left)
    }
    outside = {path for folder in SHOWN for path in folder.glob("*")}.difference(
        *shown_outputs()
    )
    outdated = outdated_settings()
    told = {str(path) for path in [*again, *outdated]}
    incomplete = PersistenceBase.incomplete

    async def incomplete_too(self, job):
        """Return the outputs of a job that are not whole, not as they were written, of other sources, or not there."""
        other = has_other_sources(job)
        files = [
            path
            for path in job.output
            if other
            or path in told
            or not (is_flagged(path, "temp") or await path.exists())
        ]
        return [*await incomplete(self, job), *files]

    async def look(dag):
        """Find what is outdated and not asked for; a job must run for what is set aside, and for the plan to be written."""
        found = find_unasked(dag)
        jobs = {id(job): job for behind in found.values() for job in behind}
        again = {
            key
            for key, job in jobs.items()
            if await incomplete_too(workflow.persistence, job)
        }
        for path, behind in found.items():
            UNASKED[path] = {str(each) for job in behind for each in job.output}
            if not again.isdisjoint(map(id, behind)):
                OLD.add(path)
        own = [path for job in dag.jobs for path in job.output if is_shown(Path(path))]
        incomplete_is_old = Path(INCOMPLETE).exists() and outdated
        if own and (OLD or outside or incomplete_is_old or not Path(PLAN).exists()):
            told.add(min(own))

    create_report = workflow.create_report

    def noted(*arguments, **options):
        """Create Snakemake's report, which looks at no job that is to run."""
        REPORTED.append(True)
        return create_report(*arguments, **options)

    workflow.create_report = noted
    PersistenceBase.incomplete = incomplete_too
    DAG.check_incomplete = refusing(DAG.check_incomplete, look)
    return damage, outside


def set_outdated_aside():
    """Take away what was changed, and tables and figures that are of another run or are to be made again.

    Tables of what was there of an unfinished run tell of what is there no more as soon as jobs begin.
    """
    if Path(INCOMPLETE).is_dir():
        set_aside(Path(INCOMPLETE), "is of an earlier run")
    changed = {path for each in DAMAGE for path in each.changed if path.is_file()}
    for path in sorted(changed):
        if path.is_relative_to(RESULTS) and ".." not in path.parts:
            set_aside(path, CHANGED)
    for path in sorted(path for path in OUTSIDE if path.is_file()):
        set_aside(path, "is of no table of this configuration")
    made = {str(path) for job in workflow.dag.needrun_jobs() for path in job.output}
    old = OLD | {path for path, before in UNASKED.items() if before & made}
    for path in sorted(old.union(filter(is_shown, map(Path, made)))):
        if path.is_file():
            set_aside(path, "is of an earlier run")
            if path == INDEX:
                set_page_aside()


def set_page_aside():
    """Move what the frame of the page shows out of the way, too; scripts of scenes, which are large, stay."""
    for name in ("index.js", "tables", "figures", "static"):
        path, target = Path(PAGE, name), Path(SET_ASIDE, "report", name)
        if path.exists():
            shutil.rmtree(target, ignore_errors=True)
            path.replace(target)


DAMAGE, OUTSIDE = check_results() if workflow.is_main_process else ([], set())
