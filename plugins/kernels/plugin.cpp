// SPDX-License-Identifier: BSD-3-Clause
#include "core/types/plugin.hpp"
#include "plugins/kernels/kernels.hpp"

namespace {

template <class K>
const graft_kernel_type& kernelType() {
  static const graft_kernel_type type = {
      sizeof(graft_kernel_type), K::name, K::doc,
      [](std::int64_t count, const double* squared_errors, double width, double* rho) {
        for (std::int64_t i = 0; i < count; ++i) K::evaluate(squared_errors[i], width, rho + 3 * i);
      }};
  return type;
}

}  // namespace

GRAFT_PLUGIN(kernels, registry) {
  registry.addKernel(kernelType<graft::Huber>());
  registry.addKernel(kernelType<graft::PseudoHuber>());
  registry.addKernel(kernelType<graft::Cauchy>());
  registry.addKernel(kernelType<graft::GemanMcClure>());
  registry.addKernel(kernelType<graft::Welsch>());
  registry.addKernel(kernelType<graft::Fair>());
  registry.addKernel(kernelType<graft::Tukey>());
  registry.addKernel(kernelType<graft::Saturated>());
  registry.addKernel(kernelType<graft::Dcs>());
}
