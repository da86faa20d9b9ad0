# SPDX-License-Identifier: BSD-3-Clause
"""Who does the runs: processes of this machine, or a cluster of Dask (Debian's python3-distributed). Both give the same
results in any order."""
import concurrent.futures
import importlib.util
import math
import os

import work

# A worker of a cluster that dies with a run is no fault of the run; the scheduler gives it to another one.
ALLOWED_DEATHS = 20


def find_quota():
    """Cores that a container's share of time makes up; a machine of 64 may give it two."""
    for path, unlimited in (('/sys/fs/cgroup/cpu.max', 'max'), ('/sys/fs/cgroup/cpu/cpu.cfs_quota_us', '-1')):
        try:
            words = open(path).read().split()
            period = words[1] if len(words) > 1 else open('/sys/fs/cgroup/cpu/cpu.cfs_period_us').read()
        except OSError:
            continue
        if words[0] != unlimited:
            return max(1, math.ceil(int(words[0]) / int(period)))
    return math.inf


def count_cores():
    """That this process may use. A worker of a cluster takes a second of a core to start: 32 of them on two cores took 77 s
    for what two did in 14."""
    return min(len(os.sched_getaffinity(0)), find_quota())


def do_here(runs, program, limit, jobs):
    """Each run is a process of its own: one that dies takes nothing with it."""
    with concurrent.futures.ThreadPoolExecutor(max_workers=max(1, jobs)) as pool:
        futures = [pool.submit(work.do_run, run['key'], run['scenario'], program, limit) for run in runs]
        try:
            for future in concurrent.futures.as_completed(futures):
                yield future.result()
        except (KeyboardInterrupt, GeneratorExit):
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def has_dask():
    return importlib.util.find_spec('distributed') is not None


def connect(address, jobs):
    import dask
    import distributed
    dask.config.set({'distributed.scheduler.allowed-failures': ALLOWED_DEATHS})
    if address != 'local':
        return distributed.Client(address), None
    cluster = distributed.LocalCluster(n_workers=max(1, jobs), threads_per_worker=1, dashboard_address=None)
    return distributed.Client(cluster), cluster


def do_on_cluster(runs, program, limit, jobs, address):
    """`address`: of a Dask scheduler, or "local": a cluster of this machine's cores. Programs and robots must lie under the
    same path on all machines."""
    import distributed
    import distributed.diagnostics.plugin
    client, cluster = connect(address, jobs)
    try:
        # A plugin, and no upload_file(): workers that come later, in the place of dead ones, get the module, too.
        client.register_worker_plugin(distributed.diagnostics.plugin.UploadFile(os.path.abspath(work.__file__)))
        futures = [client.submit(work.do_run, run['key'], run['scenario'], program, limit, key='run-' + run['key'], pure=False)
                   for run in runs]
        for future in distributed.as_completed(futures):
            yield future.result()
            future.release()
    finally:
        client.close()
        if cluster is not None:
            cluster.close()
