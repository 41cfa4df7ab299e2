#include "forms.h"

namespace dacrt::tests {
namespace {

EmbreeApi ToEmbreeApi(const Api& api) {
  EmbreeApi result;
#define X(name) result.name = api.name;
  DACRT_TESTS_EMBREE_FUNCTIONS(X)
#undef X
  result.path = api.name;
  return result;
}

}  // namespace

std::vector<Form> AllForms() {
  std::vector<Form> forms = PacketForms();
  for (const Form& form : StreamForms()) forms.push_back(form);
  return forms;
}

std::vector<RTCRayHit> Trace(const Api& api, RTCScene scene, RTCIntersectContext& context,
                             const Form& form, Query query, std::span<const RTCRayHit> rays) {
  return Trace(ToEmbreeApi(api), scene, context, form, query, rays);
}

}  // namespace dacrt::tests
