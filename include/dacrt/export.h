// What libdacrt.so exports. Everything else in it is hidden.
#pragma once

#define DACRT_API __attribute__((visibility("default")))
