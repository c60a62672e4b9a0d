# Opens the run in ParaView: File > Load State, or `paraview --state=view.py`. Written by mpm-verify.
# The colours have one range for all times, clipped at the 99.5th percentile.
import os

from paraview.simple import *

HERE = os.path.dirname(os.path.abspath(__file__)) if "__file__" in globals() else os.getcwd()
RANGES = @RANGES@
POINT = @POINT@  # edge of a particle, m


def opened(name):
    path = os.path.join(HERE, name + ".pvd")
    return PVDReader(registrationName=name, FileName=path) if os.path.exists(path) else None


def coloured(reader, array, size):
    display = Show(reader, view)
    display.Representation = "Point Gaussian"
    display.ShaderPreset = "Plain circle"
    display.GaussianRadius = size
    ColorBy(display, ("POINTS", array))
    colours = GetColorTransferFunction(array)
    colours.ApplyPreset("Viridis (matplotlib)", True)
    colours.RescaleTransferFunction(*RANGES[array])
    colours.AutomaticRescaleRangeMode = "Never"
    display.SetScalarBarVisibility(view, True)
    return display


view = GetActiveViewOrCreate("RenderView")
view.InteractionMode = "2D"
soil = opened("solid")
water = opened("water")
coloured(soil, "@SHOWN@", 0.5 * POINT)
if water is not None:
    # Water is there to be switched on: its points would cover the soil.
    Hide(water, view)
scene = GetAnimationScene()
scene.UpdateAnimationUsingDataTimeSteps()
scene.GoToLast()
view.ResetCamera(True, 0.9)
Render()
