import sys
from pathlib import Path
import bpy, numpy as np
sys.path.insert(0, "/tmp/wt/reading/tests/addon/window")
import driver
from driver import *
def settled():
    for area in window().screen.areas: area.tag_redraw()
    yield from turns(12)
def session(): return part("ui.inspect")._session
def steps():
    setup()
    bpy.data.objects.remove(bpy.data.objects["Torus"])
    yield from open_sidebar_tab()
    area, region = viewport()
    with bpy.context.temp_override(window=window(), area=area, region=region):
        bpy.ops.curvopt.add_shape(shape="mug_g1")
        bpy.ops.view3d.view_all()
    s = bpy.context.window_manager.curvopt_inspect
    s.is_on = True
    yield lambda: session()._shown is not None and session().inspector.is_settled
    for kind in ("ZEBRA","ISOPHOTES","CURVATURE"):
        s.kind = kind
        yield from turns(5)
        yield lambda: session()._shown is not None and session().inspector.is_settled
        yield from settled()
        screenshot("i_"+kind)
    s.kind="ZEBRA"; s.combs=True; s.comb_edges="ALL"; s.probe=True
    yield from turns(5)
    r=viewport()[1]
    for dx in (0,3,5):
        window().event_simulate(type="MOUSEMOVE", value="NOTHING", x=r.x+r.width//2-100+dx, y=r.y+r.height//2-20)
        yield from turns(2)
    yield from settled()
    screenshot("i_combs")
    s.combs=False; s.in_front=False
    bpy.ops.object.mode_set(mode="EDIT")
    yield from settled()
    screenshot("i_edit")
    s.in_front=True
    yield from settled()
    screenshot("i_edit_front")
    bpy.ops.object.mode_set(mode="OBJECT")
    print("MSG", session().message, session().view.draws)
    log("PASS all")
    bpy.ops.wm.quit_blender()
start(steps())
