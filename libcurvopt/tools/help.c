/* What --help prints. SPDX-License-Identifier: GPL-3.0-or-later */
#include "help.h"

#include "curvopt.h"

#include <stdio.h>

/* A format: defaults are the library's, in help_print()'s order. */
static const char help_text[] =
    "curvopt - fair surfaces from control cages\n"
    "\n"
    "usage: curvopt evaluate CAGE.obj [options]              energies of a cage's surface\n"
    "       curvopt minimize CAGE.obj -o OUT.obj [options]   the cage that minimizes one\n"
    "       curvopt --version | --help\n"
    "\n"
    "CAGE.obj is a polygon mesh, closed or open, with faces of any size. `-` reads standard input. Creases are tags "
    "as\n"
    "in OpenSubdiv's shapes, vertices counted from 0: t crease 2/1/0 A B SHARPNESS, t corner 1/1/0 V SHARPNESS. From "
    "a\n"
    "sharpness of 10 on they are infinitely sharp. t hole N/0/0 F.. names faces that are not drawn,\n"
    "t interpolateboundary 1/0/0 R the boundary rule. Where the cage is no manifold, or the surface has no finite\n"
    "energy, it is held as it is, and the report says where and why.\n"
    "\n"
    "FILEs that are written are whole or not there: each is made as FILE.PROCESS.part first. Files of such names\n"
    "that no running process holds are taken for those of killed runs and removed.\n"
    "\n"
    "options\n"
    "  --energy E           willmore, mvs, mvs_cross, variation, mehlum_tarrou, area, mean_curvature, or a mix by\n"
    "                       weights such as mvs:1,willmore:0.1 (default willmore)\n"
    "  --spontaneous-curvature C\n"
    "                       in 1 / units of the cage: bending energy, willmore or mean_curvature, is of the curvature\n"
    "                       k1 + k2 - C (Helfrich). A sphere of radius R has 2 / R. A closed result has the input's\n"
    "                       area, or the size that --area or --volume says (default %g)\n"
    "  --surface S          limit: the Catmull-Clark limit surface; polynomial: smoothed at extraordinary vertices;\n"
    "                       plane: flattened there, as in the report; auto: limit, but polynomial with third-order\n"
    "                       energies (default %s)\n"
    "  --tolerance T        relative quadrature error wanted (default %g)\n"
    "  --boundary-rule R    boundary vertices of one face: smooth, or corners as in Blender's modifier (default: the\n"
    "                       file's tag, else %s)\n"
    "  --strict             refuse cages that are no manifold, or have no finite energy everywhere\n"
    "  --blend-width N      polynomial: largest width of blends, in faces of a sector, 1 to %d (default %d). Blends "
    "take\n"
    "                       a quarter of the way to the next vertex that is not regular; on boundaries and creases\n"
    "                       8, 4 or 2 faces of that where the cage's points lie evenly, else 1\n"
    "  --threads N          threads; 0: all cores (default %d)\n"
    "  --json FILE|-        write all figures as JSON\n"
    "  --quiet              print nothing but errors\n";

static const char help_of_minimize[] =
    "for evaluate\n"
    "  --deviation-from ORIGINAL.obj\n"
    "                       also measure how far the limit surface is from that of another cage: the largest distance\n"
    "                       with a bound, and the root mean square. minimize always measures it from its input\n"
    "\n"
    "for minimize\n"
    "  -o, --output FILE    the optimized cage, written whole or not at all\n"
    "  --boundary B         what an open surface keeps: position of its boundary; tangent: also the tangent planes\n"
    "                       there; curvature: also curvature and its change; free: nothing. All but free keep "
    "vertices\n"
    "                       on infinitely sharp creases (default %s)\n"
    "  --slide              vertices that --boundary holds on a boundary or an infinitely sharp crease move along it,\n"
    "                       for a better spacing; the curve stays, to third order in the spacing of its vertices.\n"
    "                       Corners and pinned vertices stay; with tangent and curvature the boundary stays\n"
    "  --levels N           optimizations, with a subdivision between them, 1 to %d; 1 keeps the cage's own vertices\n"
    "                       (default %d)\n"
    "  --method M           gauss_newton: L-BFGS that starts from the factored Gauss-Newton matrix, then Newton's "
    "method;\n"
    "                       lmvm: L-BFGS alone, as in the report; auto: gauss_newton (default %s)\n"
    "  --max-iterations N   steps of a level (default %d)\n"
    "  --decrement-tolerance T\n"
    "                       the last level ends when a quadratic model predicts less than T of the energy to gain;\n"
    "                       coarser levels end at 1e-5 or T, whichever is larger; not for lmvm (default %g)\n"
    "  --spacing S          even: the cage's vertices are evenly spaced, and at the end only the shape changes; free:\n"
    "                       they lie where the discrete energy is least, as in the report; auto: even, and free with\n"
    "                       lmvm (default %s)\n"
    "  --strength S         how much of the shape may go, above 0 to 1: waves shorter than S / (1 - S) times the "
    "cage's\n"
    "                       radius (root mean square) lose more than half of their height, longer ones less; 1: the\n"
    "                       minimum of the energy (default %g). Below 1 no point moves farther than a fifth of that\n"
    "                       length, spacing is free, and symmetries are kept\n"
    "  --within D           the fairest surface that stays within the distance D of the input's: no vertex and no\n"
    "                       point moves farther. Spacing is free, and symmetries are kept\n"
    "  --no-crossings       the surface comes to cross itself nowhere: faces that are no neighbours repel each other\n"
    "                       from a fifth of a mean edge on, and steps are shortened. The report says by which faces\n"
    "                       the result is held. What crosses in the input may go on crossing\n"
    "  --symmetry S         symmetries to keep. keep: the cage's; rotations: those of them that are rotations; none;\n"
    "                       x, y, z or several with commas: these mirror planes and no others, refused if the cage\n"
    "                       does not have them; auto: keep, but third-order energies give some up where that lowers\n"
    "                       the energy by 6 %%, and none with lmvm (default %s)\n"
    "  --escape             leave a shape that is a saddle, downwards, on levels of up to %d vertices\n";
static const char help_of_constraints[] =
    "  --pin FILE           vertices that do not move freely, one a line, counted from 0: V stays, V line X Y Z moves\n"
    "                       along a direction, V plane X Y Z across one. After V: `surface` for the point of the\n"
    "                       limit surface that belongs to V; then `at X Y Z` for where that, or V, is put first. A\n"
    "                       number at the end, 0 to 1, says how firmly: 1 exactly, less by a spring that draws the\n"
    "                       vertex there\n"
    "  --through FILE       points of the limit surface with their places, normals and tangents, as a JSON list:\n"
    "                         [{\"vertex\": 5, \"at\": [0, 0, 1], \"normal\": [0, 0, 1]},\n"
    "                          {\"face\": 12, \"uv\": [0.25, 0.5], \"at\": [1, 0, 0], \"plane\": [1, 0, 0]},\n"
    "                          {\"vertex\": 8, \"tangent\": {\"to\": 9, \"along\": [1, 0, 0]}}]\n"
    "                       at: there, or \"here\", where it is; line, plane: it moves on the line with this direction "
    "or\n"
    "                       in the plane with this normal; tangent: toward vertex `to`, inside a face toward \"u\" or "
    "\"v\".\n"
    "                       u runs from the face's first corner to the second, v to the last; in a face that is no "
    "quad\n"
    "                       from its corner \"corner\" to the middles of edges. All is counted from 0, and holds "
    "exactly,\n"
    "                       unless \"weight\" is below 1: then by a spring, as with --pin; springs may contradict each "
    "other.\n"
    "                       Or an object with such a list, or with chains of edges and curves that these follow:\n"
    "                         {\"points\": [...], \"chains\": [{\"vertices\": [0, 1, 2], \"closed\": true,\n"
    "                          \"curve\": [[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]], \"curve_closed\": true}]}\n"
    "                       parameters: where on the curve each vertex is, in numbers of its points; without it at the\n"
    "                       nearest place\n"
    "                       `-` reads standard input; symmetries are not kept\n"
    "  --volume V, --area A, --total-mean-curvature M\n"
    "                       hold this number of the whole surface: keep for the input's, or a value in units of the\n"
    "                       cage. The volume is that inside, M is the integral of (k1 + k2) / 2. Where nothing else "
    "is\n"
    "                       held one of them only sets the size of the result, which else has the input's area\n"
    "  --reduced-volume R   hold the volume as a part R, above 0 to 1, of that of the sphere with the same area\n"
    "  --trace FILE|-       write a record of every iteration as CSV\n"
    "  --verify             examine the result without its symmetries, too, and by a Hessian from finite differences\n"
    "  --joshi-sequin          the report's settings: plane for third order, lmvm, and a fixed quadrature rule that "
    "nothing\n"
    "                       checks\n"
    "\n"
    "The report: P. Joshi, Minimizers of Curvature-Based Surface Energy, UC Berkeley, 2006.\n"
    "exit status: 0 done, 1 could not (one sentence on standard error), 2 wrong usage.\n"
    "An interrupt (Ctrl-C) ends a minimization and keeps the best cage so far, and ends an evaluation with a sentence; "
    "a\n"
    "second one ends the program.\n";

int help_print(void) {
    curvopt_options o;
    curvopt_options_init(&o, sizeof o);
    int written = printf(help_text, o.spontaneous_curvature, curvopt_surface_name(o.surface), o.tolerance,
                         curvopt_boundary_rule_name(CURVOPT_BOUNDARY_RULE_SMOOTH), CURVOPT_MAX_BLEND_WIDTH,
                         o.blend_width, o.threads);
    if (written >= 0)
        written = printf(help_of_minimize, curvopt_boundary_name(o.boundary), CURVOPT_MAX_LEVELS, o.levels,
                         curvopt_method_name(o.method), o.max_iterations, o.decrement_tolerance,
                         curvopt_spacing_name(o.spacing), o.strength, curvopt_symmetry_name(o.symmetry),
                         CURVOPT_MAX_ESCAPE_VERTICES);
    if (written >= 0)
        written = printf("%s", help_of_constraints);
    return written;
}
