#!/usr/bin/env python3
"""Draws the force chains of a run's last frame: grains in grey, contacts as thick as their normal force. Needs vtk and numpy, and no
screen.

    python3 jobs/pictures/force_chains.py RUN [PICTURE.png]

RUN must have been made with [output] contact_frames = true, in the plane. The picture of the handbook is of

    scree run jobs/element/uniaxial.toml --set output.contact_frames=true --set time.end="0.4 ms"
"""

import sys

import numpy
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

PIXELS_MAX = 580


def last(path):
    reader = vtk.vtkHDFReader()
    reader.SetFileName(path)
    reader.UpdateInformation()
    reader.SetStep(reader.GetNumberOfSteps() - 1)
    reader.Update()
    return reader.GetOutput()


def named(array, name):
    array = numpy_to_vtk(array, deep=True)
    array.SetName(name)
    return array


def coloured(source, colours, limits, array=None):
    mapper = vtk.vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray(array)
    mapper.SetLookupTable(colours)
    mapper.SetScalarRange(*limits)
    actor = vtk.vtkActor()
    actor.SetMapper(mapper)
    actor.GetProperty().LightingOff()
    return actor


def between(*colours):
    table = vtk.vtkColorTransferFunction()
    for place, colour in zip(numpy.linspace(0, 1, len(colours)), colours):
        table.AddRGBPoint(place, *colour)
    ramp = vtk.vtkLookupTable()
    ramp.SetNumberOfTableValues(256)
    ramp.Build()
    for index in range(256):
        ramp.SetTableValue(index, *table.GetColor(index / 255), 1)
    return ramp


def discs(grains):
    disc = vtk.vtkRegularPolygonSource()
    disc.SetNumberOfSides(40)
    disc.SetRadius(1)
    disc.GeneratePolylineOff()
    grains.GetPointData().SetActiveScalars("radius")
    glyphs = vtk.vtkGlyph3D()
    glyphs.SetInputData(grains)
    glyphs.SetSourceConnection(disc.GetOutputPort())
    glyphs.SetScaleModeToScaleByScalar()
    glyphs.SetScaleFactor(1)
    glyphs.OrientOff()
    return coloured(glyphs, between((0.93, 0.94, 0.95), (0.78, 0.81, 0.85)), (0, 6), "coordination")


def chains(contacts, thickest):
    force = vtk_to_numpy(contacts.GetCellData().GetArray("force_normal"))
    full = numpy.quantile(force, 0.995)
    share = numpy.clip(force / full, 0.0, 1.0)
    # A line's ends are its own: they have what it has.
    contacts.GetPointData().AddArray(named(numpy.repeat(share, 2), "share"))
    contacts.GetPointData().AddArray(named(numpy.repeat(thickest * share, 2), "thickness"))
    contacts.GetPointData().SetActiveScalars("thickness")
    tubes = vtk.vtkTubeFilter()
    tubes.SetInputData(contacts)
    tubes.SetVaryRadiusToVaryRadiusByAbsoluteScalar()
    tubes.SetNumberOfSides(8)
    tubes.CappingOn()
    return coloured(tubes, between((0.55, 0.6, 0.75), (0.85, 0.45, 0.15), (0.55, 0.05, 0.05)), (0, 1), "share"), full


def main():
    run = sys.argv[1]
    picture = sys.argv[2] if len(sys.argv) > 2 else "force_chains.png"
    grains, contacts = last(f"{run}/frames.vtkhdf"), last(f"{run}/contacts.vtkhdf")
    radius = vtk_to_numpy(grains.GetPointData().GetArray("radius"))
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(1, 1, 1)
    renderer.AddActor(discs(grains))
    actor, full = chains(contacts, 0.45 * radius.mean())
    actor.SetPosition(0, 0, radius.max())
    renderer.AddActor(actor)

    bounds = grains.GetBounds()
    size = numpy.array([bounds[1] - bounds[0], bounds[3] - bounds[2]]) + 3 * radius.max()
    pixels = (size * PIXELS_MAX / size.max()).astype(int)
    camera = renderer.GetActiveCamera()
    camera.ParallelProjectionOn()
    middle = [(bounds[0] + bounds[1]) / 2, (bounds[2] + bounds[3]) / 2]
    camera.SetFocalPoint(*middle, 0)
    camera.SetPosition(*middle, 1)
    camera.SetParallelScale(size[1] / 2)
    renderer.ResetCameraClippingRange()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(8)
    window.SetSize(*map(int, pixels))
    window.AddRenderer(renderer)
    window.Render()
    grab = vtk.vtkWindowToImageFilter()
    grab.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(picture)
    writer.SetInputConnection(grab.GetOutputPort())
    writer.Write()
    print(f"{contacts.GetNumberOfLines()} contacts, the thickest of {full:.3g} N or more: {picture}")


if __name__ == "__main__":
    main()
