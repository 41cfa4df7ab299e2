"""Draws heads over a floor with Blender's Cycles: diffuse, of glass, and with holes.

  blender -b --factory-startup -P scene.py -- PICTURE.png KINDS SIZE SAMPLES LEVELS

KINDS, separated by commas, say what becomes of one head after the other: still; deforming, at the three
time steps that Cycles gives to a mesh; moving, as an instance that turns; crowd, 80 small instances of one
mesh. The picture has SIZE * SIZE pixels; each head is subdivided LEVELS times.
Says how many seconds the picture took.
"""
import math
import sys
import time

import bpy
import mathutils

HEADS = 5  # to a side
CROWD = 80

picture, kinds, size, samples, levels = sys.argv[sys.argv.index("--") + 1:]
kinds = kinds.split(",")


def material(name, colour, **inputs):
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    for key, value in inputs.items():
        shader.inputs[key].default_value = value
    return made


def with_holes(made):
    nodes, links = made.node_tree.nodes, made.node_tree.links
    squares = nodes.new("ShaderNodeTexChecker")
    squares.inputs["Scale"].default_value = 40
    links.new(squares.outputs["Fac"], nodes["Principled BSDF"].inputs["Alpha"])
    return made


def deform(head):
    head.shape_key_add(name="now")
    later = head.shape_key_add(name="later")
    for vertex, moved in zip(head.data.vertices, later.data):
        moved.co = 1.4 * vertex.co
    for frame, value in ((0, 0), (3, 1)):
        later.value = value
        later.keyframe_insert("value", frame=frame)


def move(head):
    for frame in (1, 2):
        head.keyframe_insert("location", frame=frame)
        head.keyframe_insert("rotation_euler", frame=frame)
        head.location.z += 1
        head.rotation_euler.x += 1


def crowd(head):
    for i in range(CROWD):
        small = bpy.data.objects.new("small", head.data)
        angle = 2.4 * i
        small.location = head.location + mathutils.Vector(
            (0.15 * math.sqrt(i) * math.cos(angle), 0.15 * math.sqrt(i) * math.sin(angle), 0.02 * i - 0.9))
        small.rotation_euler = (i, 0.7 * i, 0.3 * i)
        small.scale = (0.15, 0.15, 0.15)
        bpy.context.collection.objects.link(small)
    bpy.data.objects.remove(head)


bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
materials = [material("diffuse", (0.8, 0.3, 0.2)),
             material("glass", (0.2, 0.6, 0.8), Transmission=1, Roughness=0.05),
             with_holes(material("holes", (0.7, 0.7, 0.2)))]
bpy.ops.mesh.primitive_plane_add(size=60)
bpy.context.object.data.materials.append(material("floor", (0.6, 0.6, 0.6)))
for number in range(HEADS * HEADS):
    x, y = number % HEADS, number // HEADS
    bpy.ops.mesh.primitive_monkey_add(location=(3 * x - 6, 3 * y - 6, 1.1),
                                      rotation=(0.2 * x, 0.1 * y, 0.5 * x + y))
    one = bpy.context.object
    one.data.materials.append(materials[(x + y) % len(materials)])
    kind = kinds[number % len(kinds)]
    if kind == "crowd":
        crowd(one)
        continue
    one.modifiers.new("finer", "SUBSURF").render_levels = int(levels)
    {"still": lambda head: None, "deforming": deform, "moving": move}[kind](one)

bpy.ops.object.light_add(type="AREA", location=(5, -8, 12), rotation=(0.6, 0.3, 0.2))
bpy.context.object.data.energy = 3000
bpy.context.object.data.size = 4
bpy.ops.object.light_add(type="SUN", rotation=(0.6, 0.4, 0))
bpy.context.object.data.energy = 1.5
scene.world = bpy.data.worlds.new("sky")
scene.world.color = (0.4, 0.5, 0.7)
eye = mathutils.Vector((14, -14, 10))
aim = (mathutils.Vector((0, 0, 0.5)) - eye).to_track_quat("-Z", "Y")
bpy.ops.object.camera_add(location=eye, rotation=aim.to_euler())
scene.camera = bpy.context.object

scene.render.engine = "CYCLES"
scene.cycles.device = "CPU"
scene.cycles.samples = int(samples)
scene.cycles.use_adaptive_sampling = False
scene.cycles.use_denoising = False
scene.render.use_motion_blur = True
scene.render.resolution_x = scene.render.resolution_y = int(size)
scene.render.filepath = picture
scene.frame_set(1)
start = time.monotonic()
bpy.ops.render.render(write_still=True)
print("seconds %.2f" % (time.monotonic() - start), flush=True)
