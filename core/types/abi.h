/* SPDX-License-Identifier: BSD-3-Clause */
/*
 * The only thing a plugin and its host must agree on. Plain C data and function
 * pointers; no C++ type, exception or allocation crosses. Authors use the C++
 * layer of core/types/plugin.hpp, which fills these tables in.
 *
 * Life of a plugin: the host reads the stamp and the metadata from two sections
 * of the file without running anything of it, compares the stamp field by field,
 * loads the library, calls graft_plugin_register() with a registrar, and commits
 * what was registered only if all of it is valid. It is never unloaded, so every
 * string and table of a descriptor stays valid for the life of the process.
 *
 * Layouts: a batch holds `count` items; arrays over items are contiguous. Edge e
 * of a batch has the vertices vertices[e * arity + k], k = 0 .. arity-1. Matrices
 * are column-major. Callbacks may run on several threads at once: they keep no
 * state. They return GRAFT_OK, or GRAFT_FAILED after writing a text to `message`.
 */
#ifndef GRAFT_CORE_TYPES_ABI_H
#define GRAFT_CORE_TYPES_ABI_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GRAFT_ABI_MAGIC 0x54465247u /* "GRFT" in little-endian bytes */
#define GRAFT_ABI_MAJOR 1u
#define GRAFT_ABI_MINOR 3u
#define GRAFT_STAMP_SECTION ".graft.stamp"
#define GRAFT_METADATA_SECTION ".graft.meta"
#define GRAFT_REGISTER_SYMBOL "graft_plugin_register"

enum { GRAFT_OK = 0, GRAFT_FAILED = 1 };
enum { GRAFT_DYNAMIC = -1 };

/* Room for an error text that a callback fills in (always zero-terminated). */
typedef struct graft_message {
  char text[256];
} graft_message;

/* Compared field by field before the library is loaded. */
typedef struct graft_abi_stamp {
  uint32_t magic;
  uint32_t stamp_size;
  uint32_t abi_major; /* must be equal */
  uint32_t abi_minor; /* the plugin's may be older */
  uint32_t size_of_real;
  uint32_t size_of_pointer;
  uint32_t size_of_vertex_type;
  uint32_t size_of_edge_type;
  uint32_t size_of_registrar; /* smaller in plugins of an older minor version */
  uint32_t sanitizers;        /* bit 0 address, bit 1 thread: runtimes must match */
  uint32_t isa; /* bit 0 AVX, bit 1 AVX2, bit 2 FMA, bit 3 AVX-512F that the plugin needs */
  uint32_t reserved;
  char name[64];
  char version[32];
  char license[32];
  char requires_plugins[128]; /* names, separated by blanks, loaded before this one */
} graft_abi_stamp;

typedef struct graft_edge_batch graft_edge_batch;

/* ---- relaxation: a start that needs no estimates ------------------------- */

/* Where the constraints of a manifold are dropped, many problems become linear: for poses,
 * rotations taken as free matrices, and after that translations. A relaxation is a sequence
 * of such linear least-squares problems. In a stage a vertex has an unknown matrix Y of
 * rows x columns, an edge weighted equations sum_k A_k Y_k = B; what was solved is put back
 * on the manifold before the next stage. Source of the idea for poses: Carlone, Tron,
 * Daniilidis, Dellaert, "Initialization techniques for 3D SLAM", ICRA 2015. */
enum { GRAFT_RELAXATION_STAGES = 2 };

typedef struct graft_vertex_relaxation {
  uint32_t struct_size;
  int32_t rows[GRAFT_RELAXATION_STAGES];    /* of Y, 0 = no part in this stage */
  int32_t columns[GRAFT_RELAXATION_STAGES]; /* of Y; equal for all vertices of an edge */
  /* The Y (column-major) of an estimate. */
  void (*relax)(int32_t stage, const double* x, double* y);
  /* Sets the part of the estimate x that the stage is about to what is nearest to Y;
   * GRAFT_FAILED if Y determines nothing. */
  int (*restore)(int32_t stage, const double* y, double* x);
} graft_vertex_relaxation;

typedef struct graft_edge_relaxation {
  uint32_t struct_size;
  int32_t rows[GRAFT_RELAXATION_STAGES]; /* equations, 0 = no part in this stage */
  /* The equations of one edge, weighted by its information (given in the batch), at
   * estimates that hold what earlier stages found. `matrices`: the A_k side by side for the
   * slots that take part, rows x (sum of their Y's rows); `right`: rows x columns. Both
   * column-major. GRAFT_FAILED if this edge has none. */
  int (*equations)(const graft_edge_batch* batch, int32_t stage, double* matrices, double* right);
} graft_edge_relaxation;

/* ---- vertex types ------------------------------------------------------- */

typedef struct graft_vertex_type {
  uint32_t struct_size;
  const char* tag;     /* name in files */
  const char* doc;     /* one line */
  const char* fields;  /* names of the numbers in a file, separated by blanks */
  int32_t ambient_dim; /* numbers of an estimate, and of a line in a file */
  int32_t tangent_dim;
  /* The neutral element (ambient_dim numbers); where vertices made without an estimate begin. */
  void (*identity)(double* x);
  /* Makes numbers from a file a valid estimate, in place (e.g. unit quaternion);
   * numbers that are valid already must keep every bit. */
  int (*normalize)(double* x, graft_message* message);
  /* out = x [+] delta, for `count` items. `out` may be `x`. */
  void (*plus)(int64_t count, const double* x, const double* delta, double* out);
  /* delta with b [+] delta = a, for `count` items. */
  void (*minus)(int64_t count, const double* a, const double* b, double* delta);
  const graft_vertex_relaxation* relaxation; /* or null */
} graft_vertex_type;

/* ---- resources ---------------------------------------------------------- */

/* Big read-only data that edges share: loaded once, referred to by id. In a file:
 * "TAG id token token ...". File names among the tokens are relative to `directory`. */
typedef struct graft_resource_type {
  uint32_t struct_size;
  const char* tag;
  const char* doc;
  const char* fields;
  /* Returns the loaded resource or null after writing a message. */
  const void* (*load)(const char* directory, int32_t token_count, const char* const* tokens,
                      graft_message* message);
  void (*destroy)(const void* resource);
} graft_resource_type;

/* ---- edge types --------------------------------------------------------- */

/* Edges of one type and one shape (arity, error and measurement dimension). */
struct graft_edge_batch {
  uint32_t struct_size;
  int32_t arity;
  int32_t error_dim;
  int32_t measurement_dim;
  int32_t association_dim;
  int32_t resource_count;
  int64_t count;
  const double* const* vertices;       /* count * arity pointers to estimates */
  const double* const* measurements;   /* count pointers to measurement_dim numbers */
  const double* const* associations;   /* count pointers to association_dim numbers */
  const double* const* information;    /* count pointers to error_dim x error_dim numbers; only for
                                          associate() and relaxations */
  const void* const* const* resources; /* count pointers to resource_count resources */
};

enum {
  /* Edge error depends on the vertices only up to a common motion; without this
   * flag an edge of arity 1 anchors its component. Informational. */
  GRAFT_EDGE_RELATIVE = 1,
  /* The same vertex may stand in several slots. */
  GRAFT_EDGE_ALLOWS_REPEATS = 2,
  /* propagate() to any slot but the first looks at the first vertex alone, so that
   * it may be called while others are not known yet. */
  GRAFT_EDGE_FIRST_PLACES = 4,
  /* associate() also enumerates what there is to choose from, see there. */
  GRAFT_EDGE_HAS_ALTERNATIVES = 8
};

/* For `first` of associate(): the choice number first - GRAFT_ALTERNATIVE. */
enum { GRAFT_ALTERNATIVE = 2 };

typedef struct graft_edge_type {
  uint32_t struct_size;
  uint32_t flags;
  const char* tag;
  const char* doc;
  const char* fields;      /* names of the measurement's numbers */
  int32_t arity;           /* number of vertices, or GRAFT_DYNAMIC */
  int32_t error_dim;       /* or GRAFT_DYNAMIC: then shape() tells */
  int32_t measurement_dim; /* or GRAFT_DYNAMIC: then shape() tells */
  int32_t association_dim; /* numbers that associate() keeps per edge; 0 = none */
  int32_t resource_count;
  const char* const* slot_types;     /* vertex tags: `arity`, or dynamic_slots if dynamic */
  const char* const* resource_types; /* resource_count tags */
  /* Dynamic types only: dimensions for an arity; GRAFT_FAILED for a bad arity. */
  int (*shape)(int32_t arity, int32_t* error_dim, int32_t* measurement_dim, graft_message* message);
  /* Makes the numbers of a file a valid measurement, in place. */
  int (*normalize)(int32_t measurement_dim, double* measurement, graft_message* message);
  /* errors: count * error_dim. jacobians, if not null: per edge one column-major
   * error_dim x (sum of the slots' tangent dims) matrix, slots side by side. */
  int (*evaluate)(const graft_edge_batch* batch, double* errors, double* jacobians,
                  graft_message* message);
  /* Null, or: chooses anew what each edge is associated with (nearest grasp, ...)
   * at the current estimates by the edge's own metric, writes associations and
   * sets changed[e] to 1 where it differs from the one given. `first` is 1 where
   * there is no earlier association. With GRAFT_EDGE_HAS_ALTERNATIVES `first` may also
   * be GRAFT_ALTERNATIVE + k: writes the association with the edge's k-th choice (k = 0, 1,
   * ..., the same for the same edge, whatever the estimates) and sets changed[e] to 1, or
   * to 0 if there are no more than k. */
  int (*associate)(const graft_edge_batch* batch, int32_t first, double* associations,
                   uint8_t* changed, graft_message* message);
  /* Null, or: the estimate of the vertex in slot `to` that makes those entries of the
   * error zero that depend on it, given the others (used to spread initial guesses); GRAFT_FAILED
   * if the edge cannot tell. One edge; `vertices` as in a batch. */
  int (*propagate)(const graft_edge_batch* batch, int32_t to, double* estimate);
  /* Dynamic types: number of slot_types; the last stands for all further slots. Else 0. */
  int32_t dynamic_slots;
  const graft_edge_relaxation* relaxation; /* or null */
} graft_edge_type;

/* ---- robust kernels ----------------------------------------------------- */

typedef struct graft_kernel_type {
  uint32_t struct_size;
  const char* name;
  const char* doc;
  /* rho[0..2] = kernel value, first and second derivative at the squared error s >= 0. */
  void (*evaluate)(int64_t count, const double* squared_errors, double width, double* rho);
} graft_kernel_type;

/* ---- linear solvers ----------------------------------------------------- */

/* Lower triangle of a symmetric block matrix: block column j has the blocks
 * rows[columns[j]] = j (diagonal first) .. rows[columns[j+1]-1], rising. Block b is
 * a column-major dim(row) x dim(column) matrix that begins at values[offsets[b]]. */
typedef struct graft_block_pattern {
  uint32_t struct_size;
  int32_t block_count;    /* block rows = block columns */
  const int32_t* dims;    /* block_count */
  const int64_t* columns; /* block_count + 1 */
  const int32_t* rows;    /* columns[block_count] */
  const int64_t* offsets; /* columns[block_count] */
} graft_block_pattern;

enum { GRAFT_NOT_POSITIVE_DEFINITE = 2, GRAFT_OUT_OF_MEMORY = 3 };

typedef struct graft_solver_type {
  uint32_t struct_size;
  const char* name;
  const char* doc;
  const char* license;
  void* (*create)(int32_t threads);
  void (*destroy)(void* self);
  /* Symbolic work, once per pattern; the pattern stays valid until the next call. */
  int (*analyze)(void* self, const graft_block_pattern* pattern, graft_message* message);
  /* Factors values + diag(damping); damping may be null. Returns
   * GRAFT_NOT_POSITIVE_DEFINITE with the failed block in *failed_block. */
  int (*factorize)(void* self, const double* values, const double* damping, int32_t* failed_block,
                   graft_message* message);
  /* x = A^-1 b with the last factor; both of the full scalar dimension. */
  int (*solve)(void* self, const double* b, double* x, graft_message* message);
  /* Since minor version 3; or null. After analyze(): the bytes that factorize() will take, so
   * that the host refuses what does not fit before memory is taken; 0 = it cannot tell. */
  double (*factor_bytes)(void* self);
} graft_solver_type;

/* ---- file loaders ------------------------------------------------------- */

/* What a loader fills. Calls return GRAFT_OK, or GRAFT_FAILED once the host wants
 * the loader to stop (the message is the host's business). line/column 0 = unknown. */
typedef struct graft_graph_sink {
  uint32_t struct_size;
  void* host;
  int (*add_vertex)(void* host, const char* tag, int64_t id, const double* estimate, int32_t count,
                    int64_t line);
  int (*add_resource)(void* host, const char* tag, int64_t id, int32_t token_count,
                      const char* const* tokens, int64_t line);
  /* `information`: upper triangle, row by row. */
  int (*add_edge)(void* host, const char* tag, int32_t arity, const int64_t* vertices,
                  int32_t resource_count, const int64_t* resources, int32_t measurement_count,
                  const double* measurement, int32_t information_count, const double* information,
                  int64_t line);
  int (*fix_vertex)(void* host, int64_t id, int64_t line);
  /* severity 0 note, 1 warning, 2 error, 3 no usable result; path null = the file loaded. */
  void (*report)(void* host, int32_t severity, const char* path, int64_t line, int64_t column,
                 const char* text);
  /* Since minor version 3. Of the edge that was added last, once each: its robust kernel, by
   * the name that a plugin gives it, with its width > 0; and its level >= 0 (a solve takes the
   * edges of one level, usually 0). An edge without keeps none, and level 0. */
  int (*set_kernel)(void* host, const char* name, double width, int64_t line);
  int (*set_level)(void* host, int32_t level, int64_t line);
} graft_graph_sink;

typedef struct graft_loader_type {
  uint32_t struct_size;
  const char* name;
  const char* doc;
  const char* extensions; /* with dot, separated by blanks, e.g. ".g2o .graph" */
  /* 1 if the first bytes look like this format. */
  int (*recognizes)(const char* path, const char* head, int64_t size);
  int (*load)(const char* path, const graft_graph_sink* sink);
} graft_loader_type;

/* ---- initial guesses ---------------------------------------------------- */

/* Edges of one type and one shape, as a guess sees them. The batch points into the
 * problem's estimates, so that callbacks of the type see at once what a guess writes;
 * its information is given. */
typedef struct graft_guess_group {
  uint32_t struct_size;
  const graft_edge_type* type;
  const int64_t* vertices; /* batch.count * arity indices into the problem's vertices */
  graft_edge_batch batch;
} graft_guess_group;

/* Vertices by rising id; groups by tag and shape, edges of a group by vertex ids. */
typedef struct graft_guess_problem {
  uint32_t struct_size;
  int64_t vertex_count;
  const graft_vertex_type* const* types;
  const int64_t* ids;
  const uint8_t* held;      /* 1 = fixed, or holds the gauge: must keep its estimate */
  double* const* estimates; /* to be written where not held */
  uint8_t* placed;          /* to be set to 1 where an estimate was written */
  int64_t group_count;
  const graft_guess_group* groups;
} graft_guess_problem;

typedef struct graft_guess_type {
  uint32_t struct_size;
  const char* name;
  const char* doc;
  /* Writes estimates to begin with. What it leaves open is placed along spanning trees
   * that begin at what it placed. GRAFT_FAILED, with the reason, if it has no guess. */
  int (*guess)(const graft_guess_problem* problem, graft_message* message);
} graft_guess_type;

/* ---- registration ------------------------------------------------------- */

typedef struct graft_registrar {
  uint32_t struct_size;
  void* host;
  void (*add_vertex_type)(void* host, const graft_vertex_type* type);
  void (*add_edge_type)(void* host, const graft_edge_type* type);
  void (*add_resource_type)(void* host, const graft_resource_type* type);
  void (*add_kernel_type)(void* host, const graft_kernel_type* type);
  void (*add_solver_type)(void* host, const graft_solver_type* type);
  void (*add_loader_type)(void* host, const graft_loader_type* type);
  void (*add_guess_type)(void* host, const graft_guess_type* type);
} graft_registrar;

typedef int (*graft_register_function)(const graft_registrar* registrar, graft_message* message);

#ifdef __cplusplus
}
#endif

#endif /* GRAFT_CORE_TYPES_ABI_H */
