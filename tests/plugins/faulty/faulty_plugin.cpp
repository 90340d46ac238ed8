// SPDX-License-Identifier: BSD-3-Clause
// A plugin with one type of each kind that is right, unless the environment
// variable GRAFT_TEST_FAULT names a fault. Written against the C interface, as
// an author without our C++ layer would.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <stdexcept>
#include <thread>

#include "core/types/stamp.hpp"
#include "tests/plugins/faulty/dense_solver.hpp"

namespace {

bool fault(const char* name) {
  static const char* const chosen = std::getenv("GRAFT_TEST_FAULT");
  return chosen != nullptr && std::strcmp(chosen, name) == 0;
}

int failed(graft_message* message, const char* text) {
  std::strncpy(message->text, text, sizeof message->text - 1);
  return GRAFT_FAILED;
}

/// "<how>_in_<where>" ends, throws or hangs in any of the functions below.
void spoil(const char* where) {
  static const char* const chosen = std::getenv("GRAFT_TEST_FAULT");
  const char* in = chosen == nullptr ? nullptr : std::strstr(chosen, "_in_");
  if (in == nullptr || std::strcmp(in + 4, where) != 0) return;
  const auto is = [&](const char* how) {
    return std::strncmp(chosen, how, std::size_t(in - chosen)) == 0;
  };
  if (is("throws")) throw std::runtime_error("thrown by the plugin");
  if (is("crashes")) {
    int* volatile nowhere = nullptr;
    *nowhere = 1;
  }
  if (is("aborts")) std::abort();
  if (is("exits")) std::exit(0);
  if (is("sleeps")) std::this_thread::sleep_for(std::chrono::milliseconds(60));
  while (is("hangs")) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

// ---- a point in the plane -------------------------------------------------

void identity(double* x) {
  spoil("identity");
  x[0] = x[1] = fault("identity_nan") ? std::nan("") : 0;
}

int normalize(double* x, graft_message*) {
  spoil("normalize");
  if (fault("normalize_throws")) throw std::runtime_error("thrown by a vertex");
  if (fault("normalize_rounds")) x[0] = static_cast<float>(x[0]);
  return GRAFT_OK;
}

void plus(std::int64_t count, const double* x, const double* delta, double* out) {
  spoil("plus");
  if (fault("plus_in_place")) std::memset(out, 0, std::size_t(2 * count) * sizeof(double));
  for (std::int64_t i = 0; i < 2 * count; ++i) {
    out[i] = x[i] + delta[i] + (fault("plus_zero") ? 1e-4 : 0);
  }
  if (fault("plus_before")) out[-1] = 0;
}

void minus(std::int64_t count, const double* a, const double* b, double* delta) {
  while (fault("minus_hangs")) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  for (std::int64_t i = 0; i < count; ++i) {
    const double sign = fault("minus_swapped") ? -1 : 1;
    delta[2 * i] = sign * (a[2 * i] - b[2 * i]);
    if (fault("minus_unwritten")) continue;
    delta[2 * i + 1] = sign * (a[2 * i + 1] - b[2 * i + 1]);
  }
}

graft_vertex_type pointType() {
  graft_vertex_type type = {};
  type.struct_size = sizeof type;
  type.tag = "FAULTY_POINT";
  type.doc = "point in the plane";
  type.fields = "x y";
  type.ambient_dim = type.tangent_dim = 2;
  type.identity = &identity;
  type.normalize = &normalize;
  type.plus = &plus;
  type.minus = &minus;
  return type;
}

// ---- an edge of two points: e = b - a - m + k |a|^2 -------------------------

constexpr double kBend = 0.1;

struct Item {
  const double* a;
  const double* b;
  const double* m;
};

void errorOf(const Item& item, double* e) {
  const double square = item.a[0] * item.a[0] + item.a[1] * item.a[1];
  for (int r = 0; r < 2; ++r) e[r] = item.b[r] - item.a[r] - item.m[r] + kBend * square;
  if (fault("identity_singular")) e[0] += 1 / square - 1 / square;
  if (fault("always_infinite")) e[1] = std::numeric_limits<double>::infinity();
  if (fault("not_finite") && item.a[0] > 1) e[0] = std::numeric_limits<double>::infinity();
}

void jacobianOf(const Item& item, double* j) {
  for (int c = 0; c < 2; ++c) {
    for (int r = 0; r < 2; ++r) {
      j[2 * c + r] = (r == c ? -1 : 0) + 2 * kBend * item.a[c];
      j[4 + 2 * c + r] = r == c ? 1 : 0;
    }
  }
  if (fault("jacobian_sign")) j[3] = -j[3];
  if (fault("jacobian_term")) j[0] -= 2 * kBend * item.a[0];
}

/// Numbers that two threads share where they should not.
double scratch[2];

void throughScratch(double* e) {
  std::memcpy(scratch, e, sizeof scratch);
  std::this_thread::sleep_for(std::chrono::microseconds(50));
  std::memcpy(e, scratch, sizeof scratch);
}

int evaluate(const graft_edge_batch* batch, double* errors, double* jacobians,
             graft_message* message) {
  static std::atomic<int> calls{0};
  spoil("evaluate");
  if (fault("evaluate_throws")) throw std::runtime_error("thrown by an edge");
  if (fault("evaluate_fails")) return failed(message, "not today");
  if (fault("evaluate_crashes")) std::abort();
  if (fault("evaluate_exits")) std::_Exit(0);
  if (fault("aligned") && reinterpret_cast<std::uintptr_t>(errors) % 16 != 0) std::abort();
  for (std::int64_t i = 0; i < batch->count; ++i) {
    Item item = {batch->vertices[2 * i], batch->vertices[2 * i + 1], batch->measurements[i]};
    if (fault("first_measurement")) item.m = batch->measurements[0];
    if (fault("reads_behind")) {
      const volatile double* behind = item.m + 2;
      static_cast<void>(*behind);
    }
    errorOf(item, errors + 2 * i);
    if (fault("state")) errors[2 * i] += 1e-9 * calls++;
    if (fault("threads")) throughScratch(errors + 2 * i);
    if (fault("changes_input")) const_cast<double*>(item.m)[0] += 1;
    if (jacobians == nullptr || fault("always_unwritten")) continue;
    jacobianOf(item, jacobians + 8 * i);
    if (fault("errors_differ")) errors[2 * i] += 1e-3;
    if (fault("unwritten") && i + 1 == batch->count) {
      // As if the last number had never been touched.
      std::memcpy(jacobians + 8 * i + 7, jacobians + 8 * i + 8, sizeof(double));
    }
  }
  if (fault("overruns_from_4") && batch->count > 3) errors[2 * batch->count] = 0;
  if (fault("overrun")) errors[2 * batch->count] = 0;
  if (fault("overrun_jacobian") && jacobians != nullptr) jacobians[8 * batch->count] = 0;
  return GRAFT_OK;
}

int normalizeMeasurement(std::int32_t, double* m, graft_message*) {
  if (fault("measurement_rounds")) m[0] = static_cast<float>(m[0] * 1.1);
  return GRAFT_OK;
}

int propagate(const graft_edge_batch* batch, std::int32_t to, double* estimate) {
  spoil("propagate");
  if (to != 1) return GRAFT_FAILED;
  const double* a = batch->vertices[0];
  const double bend = fault("propagate") ? 0 : kBend * (a[0] * a[0] + a[1] * a[1]);
  for (int r = 0; r < 2; ++r) estimate[r] = a[r] + batch->measurements[0][r] - bend;
  return GRAFT_OK;
}

const char* const kSlots[] = {"FAULTY_POINT", "FAULTY_POINT"};
graft_edge_type edgeType() {
  graft_edge_type type = {};
  type.struct_size = sizeof type;
  type.tag = "FAULTY_EDGE";
  type.doc = "bent difference";
  type.fields = "dx dy";
  type.arity = type.error_dim = type.measurement_dim = 2;
  type.slot_types = kSlots;
  type.normalize = &normalizeMeasurement;
  type.evaluate = &evaluate;
  type.propagate = &propagate;
  return type;
}

// ---- an edge that looks something up ----------------------------------------

int evaluateNearest(const graft_edge_batch* batch, double* errors, double* jacobians,
                    graft_message*) {
  for (std::int64_t i = 0; i < batch->count; ++i) {
    errors[i] = batch->vertices[i][0] - batch->associations[i][0];
    if (jacobians != nullptr) {
      jacobians[2 * i] = 1;
      jacobians[2 * i + 1] = 0;
    }
  }
  return GRAFT_OK;
}

/// Whole numbers there are to choose from: -kLargest .. kLargest.
constexpr int kLargest = 20;

/// The nearest whole number.
int associateNearest(const graft_edge_batch* batch, std::int32_t first, double* associations,
                     std::uint8_t* changed, graft_message*) {
  spoil("associate");
  for (std::int64_t i = 0; i < batch->count; ++i) {
    if (first >= GRAFT_ALTERNATIVE) {
      const int k = first - GRAFT_ALTERNATIVE;
      associations[i] = k - kLargest + (fault("choices_unlisted") ? 0.5 : 0) +
                        (fault("choices_depend") ? batch->vertices[i][0] : 0);
      changed[i] = k <= 2 * kLargest || fault("choices_endless") ? 1 : 0;
      continue;
    }
    const double nearest =
        std::min(std::max(std::round(batch->vertices[i][0]), 0.0 - kLargest), 0.0 + kLargest);
    changed[i] = first != 0 || nearest != associations[i] || fault("always_changed") ? 1 : 0;
    if (fault("never_changed")) changed[i] = 0;
    associations[i] = nearest;
  }
  return GRAFT_OK;
}

int normalizeNothing(std::int32_t, double*, graft_message*) { return GRAFT_OK; }

graft_edge_type nearestType() {
  graft_edge_type type = {};
  type.struct_size = sizeof type;
  type.tag = "FAULTY_NEAREST";
  type.flags = GRAFT_EDGE_HAS_ALTERNATIVES;
  type.doc = "nearest whole x";
  type.fields = "";
  type.arity = type.error_dim = type.association_dim = 1;
  type.slot_types = kSlots;
  type.normalize = &normalizeNothing;
  type.evaluate = &evaluateNearest;
  type.associate = &associateNearest;
  return type;
}

// ---- an edge over any number of points ---------------------------------------

int shape(std::int32_t arity, std::int32_t* errors, std::int32_t* measurements,
          graft_message* message) {
  spoil("shape");
  if (arity < 2) return failed(message, "at least two points");
  *errors = fault("shape_zero") ? 0 : fault("shape_huge") ? 1000000000 : 1;
  *measurements = 1;
  return GRAFT_OK;
}

int evaluateSum(const graft_edge_batch* batch, double* errors, double* jacobians, graft_message*) {
  const std::int32_t arity = fault("fixed_arity") ? 2 : batch->arity;
  for (std::int64_t i = 0; i < batch->count; ++i) {
    errors[i] = -batch->measurements[i][0];
    for (std::int32_t k = 0; k < batch->arity; ++k) {
      errors[i] += batch->vertices[i * batch->arity + k][0];
    }
    if (jacobians == nullptr) continue;
    for (std::int32_t k = 0; k < arity; ++k) {
      jacobians[(i * batch->arity + k) * 2] = 1;
      jacobians[(i * batch->arity + k) * 2 + 1] = 0;
    }
  }
  return GRAFT_OK;
}

graft_edge_type sumType() {
  graft_edge_type type = {};
  type.struct_size = sizeof type;
  type.tag = "FAULTY_SUM";
  type.doc = "sum of x";
  type.fields = "";
  type.arity = type.error_dim = type.measurement_dim = GRAFT_DYNAMIC;
  type.slot_types = kSlots;
  type.dynamic_slots = 1;
  type.shape = &shape;
  type.normalize = &normalizeNothing;
  type.evaluate = &evaluateSum;
  return type;
}

// ---- a kernel, a resource, a loader ------------------------------------------

void cauchy(std::int64_t count, const double* s, double width, double* rho) {
  spoil("kernel");
  const double w2 = width * width;
  for (std::int64_t i = 0; i < count; ++i) {
    const double inside = 1 + s[i] / w2;
    rho[3 * i] = w2 * std::log1p(s[i] / w2) + (fault("rho_zero") ? 1 : 0);
    rho[3 * i + 1] = (fault("rho_slope") ? 2 : 1) / inside;
    rho[3 * i + 2] = -1 / (w2 * inside * inside);
    if (fault("rho_derivative") && s[i] > 0) rho[3 * i + 1] = 1 / (inside * inside);
    if (fault("rho_nan")) rho[3 * i] = std::nan("");
    if (fault("rho_second")) rho[3 * i + 2] = -rho[3 * i + 2];
    if (fault("rho_falls") && s[i] > w2) {
      rho[3 * i] = w2 * w2 / s[i];
      rho[3 * i + 1] = -w2 * w2 / (s[i] * s[i]);
      rho[3 * i + 2] = 2 * w2 * w2 / (s[i] * s[i] * s[i]);
    }
  }
}

const graft_kernel_type kKernel = {sizeof kKernel, "FaultyCauchy", "w^2 log(1 + s/w^2)", &cauchy};

const void* loadNumber(const char*, std::int32_t count, const char* const* tokens,
                       graft_message* message) {
  spoil("resource");
  char* end = nullptr;
  const double number = count == 1 ? std::strtod(tokens[0], &end) : 0;
  const bool good = end != nullptr && end != tokens[0] && *end == '\0' && std::isfinite(number);
  if (good || fault("accepts_garbage")) return new double(number);
  if (!fault("refuses_silently")) failed(message, "expected one number");
  return nullptr;
}

const graft_resource_type kResource = {sizeof kResource,
                                       "FAULTY_NUMBER",
                                       "one number",
                                       "number",
                                       &loadNumber,
                                       [](const void* resource) {
                                         spoil("destroy");
                                         delete static_cast<const double*>(resource);
                                       }};

int recognizes(const char*, const char* head, std::int64_t size) {
  spoil("recognizes");
  return fault("recognizes_all") || (size >= 6 && std::memcmp(head, "FAULTY", 6) == 0) ? 1 : 0;
}

int loadNothing(const char*, const graft_graph_sink* sink) {
  // Alive as long as it calls back.
  for (int i = 0; i < 30 && fault("loads_slowly"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    sink->report(sink->host, 0, nullptr, 0, 0, "still there");
  }
  spoil("loader");
  if (fault("loads_nothing")) return GRAFT_OK;
  sink->report(sink->host, 2, nullptr, 0, 0, "this format holds nothing");
  return GRAFT_FAILED;
}

const graft_loader_type kLoader = {sizeof kLoader, "faulty",    "nothing",
                                   ".faulty",      &recognizes, &loadNothing};

/// Shifts every vertex that it may by (1, 0).
int guess(const graft_guess_problem* problem, graft_message* message) {
  spoil("guess");
  static int calls = 0;
  ++calls;
  if (fault("guess_silent")) return GRAFT_FAILED;
  if (problem->vertex_count == 0) return failed(message, "the graph is empty");
  for (std::int64_t v = 0; v < problem->vertex_count; ++v) {
    if (problem->held[v] != 0 && !fault("guess_moves_held")) continue;
    problem->estimates[v][0] += fault("guess_state") ? calls : 1;
    if (fault("guess_nan")) problem->estimates[v][0] = std::nan("");
    problem->placed[v] = problem->held[v] != 0 || fault("guess_unmarked") ? 0 : 1;
  }
  return GRAFT_OK;
}

const graft_guess_type kGuess = {sizeof kGuess, "faulty_shift", "everything one to the right",
                                 &guess};

}  // namespace

#define GRAFT_TEST_EXPORT __attribute__((visibility("default")))

extern "C" {
extern GRAFT_TEST_EXPORT const graft_abi_stamp graft_plugin_stamp;
__attribute__((used, section(GRAFT_STAMP_SECTION))) const graft_abi_stamp graft_plugin_stamp =
    graft::makeStamp("faulty", "1", "BSD-3-Clause", "");

GRAFT_TEST_EXPORT int graft_plugin_register(const graft_registrar* registrar, graft_message*) {
  void* host = registrar->host;
  static const graft_vertex_type point = pointType();
  static const graft_edge_type edge = edgeType();
  static const graft_edge_type nearest = nearestType();
  static const graft_edge_type sum = sumType();
  registrar->add_vertex_type(host, &point);
  for (const graft_edge_type* type : {&edge, &nearest, &sum}) registrar->add_edge_type(host, type);
  if (!fault("metadata")) registrar->add_kernel_type(host, &kKernel);
  registrar->add_resource_type(host, &kResource);
  registrar->add_loader_type(host, &kLoader);
  registrar->add_guess_type(host, &kGuess);
  registrar->add_solver_type(host,
                             &graft::testing::denseSolver(std::getenv("GRAFT_TEST_FAULT"), &spoil));
  return GRAFT_OK;
}
}
