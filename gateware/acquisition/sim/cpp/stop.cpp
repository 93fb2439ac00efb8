// What Verilator's $stop does here, which is how a failed assertion ends: it is noted, and the eval tells.
#include "verilated.h"

thread_local bool gateware_assertion_failed = false;

void vl_stop(const char*, int, const char*) { gateware_assertion_failed = true; }
