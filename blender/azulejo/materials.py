# SPDX-License-Identifier: MIT OR Apache-2.0
"""Materials: what goes to azulejo, and how baked light is shown."""

import math

import bpy

from .settings import MARK, original_material, uses_nodes

GROUP_NAME = "azulejo lightmap"
# Surfaces that are not Principled BSDFs, by the values of a Principled BSDF that come nearest. The exporter of Blender
# would make metals of them.
STAND_INS = {
    "BSDF_DIFFUSE": {"Roughness": 1.0, "Specular IOR Level": 0.0},
    "BSDF_GLOSSY": {"Metallic": 1.0},
    "BSDF_METALLIC": {"Metallic": 1.0},
    "BSDF_GLASS": {"Transmission Weight": 1.0, "Roughness": 0.0},
    "BSDF_REFRACTION": {"Transmission Weight": 1.0, "Roughness": 0.0},
    "BSDF_TRANSLUCENT": {"Roughness": 1.0, "Specular IOR Level": 0.0},
}
# The inputs of a Principled BSDF that matter to what is shown, with their values where there is none.
SHOWN = {
    "Base Color": (0.8, 0.8, 0.8, 1.0),
    "Metallic": 0.0,
    "Transmission Weight": 0.0,
    "Emission Color": (1.0, 1.0, 1.0, 1.0),
    "Emission Strength": 0.0,
    "Alpha": 1.0,
}


def ensure_nodes(material: bpy.types.Material) -> bpy.types.NodeTree:
    """The nodes of a material. Before Blender 5.0 it may have none: then they say what it was."""
    if not uses_nodes(material):
        colour, metallic, roughness = tuple(material.diffuse_color), material.metallic, material.roughness
        material.use_nodes = True
        node = next((n for n in material.node_tree.nodes if n.type == "BSDF_PRINCIPLED"), None)
        if node:
            node.inputs["Base Color"].default_value = colour
            node.inputs["Metallic"].default_value = metallic
            node.inputs["Roughness"].default_value = roughness
    return material.node_tree


def output_of(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The output that is in use."""
    outputs = [node for node in tree.nodes if node.type == "OUTPUT_MATERIAL"]
    # Outputs for all engines come before those for one; of each kind one is active.
    outputs.sort(key=lambda node: (not node.is_active_output, node.target != "ALL"))
    return outputs[0] if outputs else None


def surface_of(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The node that says what the surface is: the first upstream of the output that is known."""
    output = output_of(tree)
    if output is None:
        return None
    known = {"BSDF_PRINCIPLED", "EMISSION", *STAND_INS}
    seen, queue = set(), [output.inputs["Surface"]]
    while queue:
        for link in queue.pop(0).links:
            node = link.from_node
            if node in seen:
                continue
            seen.add(node)
            if node.type in known:
                return node
            queue += [socket for socket in node.inputs if socket.type == "SHADER" or node.type == "REROUTE"]
    return None


def constant_colour(material: bpy.types.Material | None) -> tuple[float, float, float]:
    """The base colour of a material; the grey of no material if it is not constant."""
    material = original_material(material)
    if material is None:
        return SHOWN["Base Color"][:3]
    if not uses_nodes(material):
        return tuple(material.diffuse_color[:3])
    node = surface_of(material.node_tree)
    socket = (node.inputs.get("Base Color") or node.inputs.get("Color")) if node else None
    if socket is None or socket.is_linked:
        return SHOWN["Base Color"][:3]
    return tuple(socket.default_value[:3])


def for_export(material: bpy.types.Material | None, made: dict, notes: list[str]) -> bpy.types.Material:
    """The material to export: the original, or what stands for it, which is remembered in `made`."""
    material = original_material(material)
    key = material.name_full if material else None
    if key in made:
        return made[key]
    result = material
    if material is None:
        # Faces without material are grey to Blender; without a material in the file they would be another grey.
        result = bpy.data.materials.new("azulejo none")
        set_value(result, {"Base Color": SHOWN["Base Color"]})
    elif uses_nodes(material):
        node = surface_of(material.node_tree)
        if node is None:
            result = bpy.data.materials.new("azulejo black")
            set_value(result, {"Base Color": (0, 0, 0, 1), "Specular IOR Level": 0.0, "Roughness": 1.0})
            notes.append(f"the surface of the material {material.name} is not understood: it is taken for black")
        elif node.type in STAND_INS:
            result = stand_in(material)
        note_pictures(node, material, notes)
    made[key] = result
    return result


def set_value(material: bpy.types.Material, values: dict) -> None:
    """Sets inputs of the Principled BSDF of a new material."""
    tree = ensure_nodes(material)
    node = next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED")
    for name, value in values.items():
        node.inputs[name].default_value = value


def stand_in(material: bpy.types.Material) -> bpy.types.Material:
    """A copy whose surface is a Principled BSDF with the colour of the original."""
    copy = material.copy()
    tree = copy.node_tree
    node = surface_of(tree)
    principled = tree.nodes.new("ShaderNodeBsdfPrincipled")
    for name, value in STAND_INS[node.type].items():
        principled.inputs[name].default_value = value
    colour = node.inputs.get("Color") or node.inputs["Base Color"]
    transfer(tree, colour, principled.inputs["Base Color"])
    if node.type in {"BSDF_GLOSSY", "BSDF_METALLIC"}:
        transfer(tree, node.inputs["Roughness"], principled.inputs["Roughness"])
    tree.links.new(principled.outputs[0], output_of(tree).inputs["Surface"])
    return copy


def note_pictures(node: bpy.types.Node | None, material: bpy.types.Material, notes: list[str]) -> None:
    """Notes if a base colour is computed by nodes: the exporter writes pictures and constants only."""
    socket = node.inputs.get("Base Color") or node.inputs.get("Color") if node else None
    if socket is None or not socket.is_linked:
        return
    direct = {"TEX_IMAGE", "RGB", "VERTEX_COLOR", "MIX", "MIX_RGB", "REROUTE", "GROUP"}
    if socket.links[0].from_node.type not in direct:
        notes.append(f"the colour of the material {material.name} comes from nodes that glTF does not know")


def transfer(tree: bpy.types.NodeTree, source: bpy.types.NodeSocket, target: bpy.types.NodeSocket) -> None:
    """Gives one input the link or the value of another."""
    if source.is_linked:
        tree.links.new(source.links[0].from_socket, target)
    else:
        target.default_value = source.default_value


def lightmap_group(image: bpy.types.Image, is_indirect: bool) -> bpy.types.NodeTree:
    """A node group that shows the light of a lightmap.

    Matt reflection becomes emission of base colour × irradiance / π. What is metal or glass keeps its surface, which
    mirrors what is there. With indirect light alone the surface stays, and the light is added to it.
    """
    group = bpy.data.node_groups.new(GROUP_NAME, "ShaderNodeTree")
    group.interface.new_socket("Surface", in_out="INPUT", socket_type="NodeSocketShader")
    for name, value in SHOWN.items():
        kind = "NodeSocketColor" if isinstance(value, tuple) else "NodeSocketFloat"
        group.interface.new_socket(name, in_out="INPUT", socket_type=kind).default_value = value
    group.interface.new_socket("Surface", in_out="OUTPUT", socket_type="NodeSocketShader")
    nodes, link = group.nodes, group.links.new
    inputs, output = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    value = inputs.outputs

    coordinates = nodes.new("ShaderNodeUVMap")
    coordinates.uv_map = MARK
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    texture.extension = "EXTEND"
    link(coordinates.outputs["UV"], texture.inputs["Vector"])

    reflected = vector_math(nodes, "MULTIPLY")
    link(value["Base Color"], reflected.inputs[0])
    link(texture.outputs["Color"], reflected.inputs[1])
    scaled = vector_math(nodes, "SCALE")
    link(reflected.outputs[0], scaled.inputs[0])
    scaled.inputs["Scale"].default_value = 1 / math.pi
    kept = nodes.new("ShaderNodeMath")
    kept.operation = "MAXIMUM"
    link(value["Metallic"], kept.inputs[0])
    link(value["Transmission Weight"], kept.inputs[1])
    light = nodes.new("ShaderNodeEmission")

    if is_indirect:
        matt = nodes.new("ShaderNodeMath")
        matt.operation = "SUBTRACT"
        matt.inputs[0].default_value = 1
        link(kept.outputs[0], matt.inputs[1])
        visible = nodes.new("ShaderNodeMath")
        visible.operation = "MULTIPLY"
        link(matt.outputs[0], visible.inputs[0])
        link(value["Alpha"], visible.inputs[1])
        link(scaled.outputs[0], light.inputs["Color"])
        link(visible.outputs[0], light.inputs["Strength"])
        both = nodes.new("ShaderNodeAddShader")
        link(value["Surface"], both.inputs[0])
        link(light.outputs[0], both.inputs[1])
        link(both.outputs[0], output.inputs[0])
        arrange(group)
        return group

    emitted = vector_math(nodes, "SCALE")
    link(value["Emission Color"], emitted.inputs[0])
    link(value["Emission Strength"], emitted.inputs["Scale"])
    total = vector_math(nodes, "ADD")
    link(scaled.outputs[0], total.inputs[0])
    link(emitted.outputs[0], total.inputs[1])
    link(total.outputs[0], light.inputs["Color"])
    surface = nodes.new("ShaderNodeMixShader")
    link(kept.outputs[0], surface.inputs[0])
    link(light.outputs[0], surface.inputs[1])
    link(value["Surface"], surface.inputs[2])
    hole = nodes.new("ShaderNodeBsdfTransparent")
    cut = nodes.new("ShaderNodeMixShader")
    link(value["Alpha"], cut.inputs[0])
    link(hole.outputs[0], cut.inputs[1])
    link(surface.outputs[0], cut.inputs[2])
    link(cut.outputs[0], output.inputs[0])
    arrange(group)
    return group


def vector_math(nodes: bpy.types.Nodes, operation: str) -> bpy.types.Node:
    """A node that computes with colours as vectors, which are not clamped."""
    node = nodes.new("ShaderNodeVectorMath")
    node.operation = operation
    return node


def arrange(tree: bpy.types.NodeTree) -> None:
    """Places nodes in columns by their distance from the inputs, so that the group can be read."""
    depth: dict = {}

    def column(node: bpy.types.Node) -> int:
        if node not in depth:
            before = [link.from_node for socket in node.inputs for link in socket.links]
            depth[node] = 1 + max((column(n) for n in before), default=-1)
        return depth[node]

    rows: dict = {}
    for node in tree.nodes:
        place = column(node)
        node.location = (place * 220, -rows.get(place, 0) * 260)
        rows[place] = rows.get(place, 0) + 1


def showing(material: bpy.types.Material | None, group: bpy.types.NodeTree) -> bpy.types.Material:
    """A copy of a material that shows the light of a lightmap."""
    name = material.name if material else "none"
    copy = material.copy() if material else bpy.data.materials.new(name)
    copy.name = f"{name} ({MARK})"
    copy.azulejo.is_baked = True
    copy.azulejo.original = material
    tree = ensure_nodes(copy)
    if material is None:
        set_value(copy, {"Base Color": SHOWN["Base Color"]})
    output = output_of(tree) or tree.nodes.new("ShaderNodeOutputMaterial")
    surface = surface_of(tree)
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    node.label = node.name = GROUP_NAME
    node.location = output.location
    output.location.x += 240
    if output.inputs["Surface"].is_linked:
        tree.links.new(output.inputs["Surface"].links[0].from_socket, node.inputs["Surface"])
    for name in SHOWN:
        read_input(tree, surface, name, node.inputs[name])
    tree.links.new(node.outputs["Surface"], output.inputs["Surface"])
    return copy


def read_input(
    tree: bpy.types.NodeTree, surface: bpy.types.Node | None, name: str, target: bpy.types.NodeSocket
) -> None:
    """Sets an input of the group from the surface, whatever node that is."""
    kind = surface.type if surface else None
    if kind == "BSDF_PRINCIPLED":
        if name in surface.inputs:
            transfer(tree, surface.inputs[name], target)
    elif kind == "EMISSION":
        other = {"Emission Color": "Color", "Emission Strength": "Strength"}.get(name)
        if other:
            transfer(tree, surface.inputs[other], target)
        elif name == "Base Color":
            target.default_value = (0, 0, 0, 1)
    elif kind in STAND_INS:
        if name == "Base Color":
            transfer(tree, surface.inputs.get("Color") or surface.inputs["Base Color"], target)
        elif name in STAND_INS[kind]:
            target.default_value = STAND_INS[kind][name]
    elif name == "Metallic":
        # A surface that is not understood stays as it is.
        target.default_value = 1.0
