"""Draw the README's pictures of the report's flows and of `pcsmooth plot`."""

from readme_pictures import DATA, save

from pcsmooth import denoise, read_cloud
from pcsmooth.plots.cloud_figure import cloud_figure
from pcsmooth.plots.valued_clouds import by_displacement
from pcsmooth.plots.views import facing
from pcsmooth_experiments.experiment import Inputs
from pcsmooth_experiments.plane import spacing_gaps


def gaps() -> None:
    """Show how evenly the report's flows leave points."""
    outcome = spacing_gaps.EXPERIMENT.run(Inputs(DATA / "report"))
    save(outcome.draw(), "spacing_gaps.png")


def kinect() -> None:
    """Show the Kinect scan as `pcsmooth plot` does."""
    points = read_cloud(DATA / "scans" / "kinect_milk.ply").points
    result = denoise(points)
    shown = by_displacement(points, result.points)
    save(cloud_figure(shown, view=facing(result.normals)), "kinect_plot.png")


if __name__ == "__main__":
    gaps()
    kinect()
