# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery: the report's tables, figures and open questions from the committed cages, as one HTML page.

`make.py` is its command. Its other files, each using only those before it, and the add-on's packages:

    store                   items, and what of them is finished on disk        (no bpy)
    schedule                makes items in an order that their needs allow     (no bpy)
    dense                   dense meshes of any kind of surface                (no bpy)
    solve                   optimizations, their figures, their certificates   (no bpy)
    plot, png, markup       SVG, PNG, HTML                                     (no bpy)
    torus_profile           tori of revolution by rules of few points          (no bpy)
    torus_nets              tori on coarse nets                                (no bpy)
    answers                 the other questions' experiments                   (no bpy)
    contents                the list of all items                              (no bpy)
    figures                 the tables' figures as rows                        (no bpy)
    answers_page, page      what people see                                    (no bpy)
    pictures                rows and sheets of shapes
    make                    the command

An item is made again when its inputs, the library's file, or the source of the module that makes it have changed.
"""
