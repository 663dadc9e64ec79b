// The functions behind the registry's lines.
#ifndef AXISCAL_CORE_PUBLISHED_SOURCES_H_
#define AXISCAL_CORE_PUBLISHED_SOURCES_H_

#include "core/published/comparison.h"

namespace axiscal::published {

// Yao 2022, Table 4.5: location errors of a machine Z Y X B | C from eccentricities of BX, BY, CR and CA, and of CR
// with a second tool. Zt and Xt, machine coordinates that the printed formulas take for levers, stand in the sessions'
// headers (`zt_mm`, `xt_mm`): the machine's description does not know them, and nothing else needs them.
absl::StatusOr<Comparison> YaoTable45(const machine::Machine& machine, const std::vector<session::Session>& sessions);

// Yao 2022, the rule behind Fig 4.30 and equation 3.13 (yao_compensation.h): what each changes and leaves at the tool
// point at the ends of a program's moves, beside the exact inverse of the chain.
absl::StatusOr<Comparison> YaoCompensation(const machine::Machine& machine, const Program& program);
absl::StatusOr<Comparison> YaoEquation313(const machine::Machine& machine, const Program& program);

// Ibaraki, Iritani, Matsushita: displacement of a table with two rotary axes at each of their positions, and the maps
// of both, from touches of plane faces that were touched at 0, 0 too: closed form, against that reference pose. Beside
// it the table's displacement by the machine's declared errors, fitted to all touches with the artefact's place free.
absl::StatusOr<Comparison> IbarakiMaps(const machine::Machine& machine, const std::vector<session::Session>& sessions);

}  // namespace axiscal::published

#endif  // AXISCAL_CORE_PUBLISHED_SOURCES_H_
