"""Presses of many tissues on all cores, or machines, of a Dask cluster: dask_presses.py [ADDRESS]

Without the address of a scheduler it starts four processes here (python3-distributed, python3-dask). Models are sent as
what they were made from, so each process makes its own; the bits are those of one process. A shared cache folder spares
them the set-up: they write it side by side.
"""
import os
import sys
import tempfile

import numpy as np

import palpate


def press(young, cache):
    """Force, N, 1 mm past first touch, and a hash of all that follows."""
    model = palpate.Model("layer_sphere", set={"material[0].young": young}, threads=1, cache=cache)
    with palpate.Simulation(model) as simulation:
        return simulation.step(model.pose_at(0.001), ticks=200).force[2], simulation.hash()


def main():
    from distributed import Client, LocalCluster
    with tempfile.TemporaryDirectory() as cache:
        cluster = sys.argv[1] if len(sys.argv) > 1 else LocalCluster(n_workers=4, threads_per_worker=1,
                                                                     dashboard_address=None)
        with Client(cluster) as client:
            moduli = [float(young) for young in np.linspace(2000, 5000, 8)]
            forces = client.gather(client.map(press, moduli, cache=cache))
            workers = len(client.scheduler_info()["workers"])
        if not isinstance(cluster, str):
            cluster.close()
        for young, (force, _) in zip(moduli, forces):
            print(f"{young:5.0f} Pa: {1e3 * force:6.2f} mN")
        assert press(moduli[-1], None) == forces[-1], "a process of its own has other bits"
        print(f"{workers} processes, {len(os.listdir(cache))} set-ups kept; the same bits as alone")


if __name__ == "__main__":
    main()
