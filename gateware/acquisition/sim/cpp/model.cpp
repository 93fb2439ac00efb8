// The verilated block behind three C functions. Pins are bits of a word, as src/model.rs names them.
#include <cstdint>
#include <memory>

#include HEADER
#include "verilated.h"

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)

// See stop.cpp.
extern thread_local bool gateware_assertion_failed;

namespace {
struct Block {
    VerilatedContext context;
    std::unique_ptr<MODEL> model;
};
}  // namespace

extern "C" void* JOIN(NAME, _new)(uint32_t seed, bool assertions) {
    auto* block = new Block;
    // Whatever has no reset starts with any value.
    block->context.randReset(2);
    block->context.randSeed(static_cast<int>(seed & 0x7FFFFFFF) | 1);
    block->context.assertOn(assertions);
    block->context.fatalOnError(false);
    block->model = std::make_unique<MODEL>(&block->context, "gateware");
    return block;
}

extern "C" void JOIN(NAME, _delete)(void* handle) {
    auto* block = static_cast<Block*>(handle);
    block->model->final();
    delete block;
}

extern "C" uint32_t JOIN(NAME, _eval)(void* handle, uint32_t pins) {
    auto& model = *static_cast<Block*>(handle)->model;
    model.clk = pins & 1;
    model.rst_n = pins >> 1 & 1;
    model.spi_sck = pins >> 2 & 1;
    model.spi_csn = pins >> 3 & 1;
    model.spi_mosi = pins >> 4 & 1;
    model.adc_sdo = pins >> 5 & 1;
    gateware_assertion_failed = false;
    model.eval();
    return model.spi_miso | model.data_ready << 1 | model.adc_cnv << 2 | model.adc_sck << 3 | model.adc_din << 4
        | model.scan_ready << 5 | (gateware_assertion_failed ? 1u << 31 : 0);
}
