// What LinuxCNC's kinematics ask of its hardware layer: pins by name, in the memory of this process. So its own compiled
// kinematics (Debian's linuxcnc-uspace) can be asked where the joints stand, without a running machine.
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
  char name[64];
  double value;  // of bits and integers the first bytes
} pins[200];
static int count = 0;

int hal_init(const char* name) { return 1; }
int hal_ready(int component) { return 0; }
int hal_exit(int component) { return 0; }
void* hal_malloc(long size) { return calloc(1, (size_t)size); }
void rtapi_print(const char* format, ...) {}
void rtapi_print_msg(int level, const char* format, ...) {}

static int take(void** at, const char* format, va_list arguments) {
  if (count == 200) return -1;
  vsnprintf(pins[count].name, sizeof(pins[count].name), format, arguments);
  *at = &pins[count++].value;
  return 0;
}

#define PIN(function)                                                             \
  int function(int direction, void** at, int component, const char* format, ...) { \
    va_list arguments;                                                            \
    va_start(arguments, format);                                                  \
    const int result = take(at, format, arguments);                               \
    va_end(arguments);                                                            \
    return result;                                                                \
  }
PIN(hal_pin_float_newf)
PIN(hal_pin_bit_newf)
PIN(hal_pin_s32_newf)

int hal_pin_float_new(const char* name, int direction, void** at, int component) {
  return hal_pin_float_newf(direction, at, component, "%s", name);
}
int hal_pin_bit_new(const char* name, int direction, void** at, int component) {
  return hal_pin_bit_newf(direction, at, component, "%s", name);
}
int hal_pin_s32_new(const char* name, int direction, void** at, int component) {
  return hal_pin_s32_newf(direction, at, component, "%s", name);
}

// 0: there is no such pin.
int set_pin(const char* name, double value) {
  for (int i = 0; i < count; ++i) {
    if (strcmp(pins[i].name, name) != 0) continue;
    pins[i].value = value;
    return 1;
  }
  return 0;
}
