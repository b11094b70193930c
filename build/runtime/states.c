/* FMU states: a copy of the instance's block, in memory or as bytes with version and checksum. */
#include "instance.h"

#include <stdlib.h>
#include <string.h>

#define STATE_MAGIC UINT64_C(0x666c657868657873) /* "flexhexs" */

/* In memory; the block follows. The magic word stands where a freed chunk keeps its bytes. */
typedef struct {
  const flexhex_model *model;
  size_t size;
  uint64_t magic;
  uint64_t padding; /* the block begins at a multiple of 16 bytes */
} snapshot;

/* As bytes; the block follows. */
typedef struct {
  char format[8];
  uint32_t version, byte_order;
  uint64_t model, size, checksum;
} envelope;

static const char FORMAT[8] = {'f', 'l', 'e', 'x', 'h', 'e', 'x', 'S'};
enum { VERSION = 1, BYTE_ORDER_MARK = 0x01020304 };

/* FNV-1a, 64 bits (Fowler, Noll, Vo) */
static uint64_t hash(uint64_t seed, const void *data, size_t size) {
  const unsigned char *byte = (const unsigned char *)data;
  for (size_t k = 0; k < size; ++k) {
    seed = (seed ^ byte[k]) * UINT64_C(0x100000001b3);
  }
  return seed;
}

static const uint64_t HASH_START = UINT64_C(0xcbf29ce484222325);

/* What stands before the block when its bytes are a state of this FMU */
static envelope envelope_of(const flexhex_instance *m, const void *block) {
  const char *guid = FLEXHEX_MODEL.guid;
  envelope e;
  memset(&e, 0, sizeof e);
  memcpy(e.format, FORMAT, sizeof e.format);
  e.version = VERSION;
  e.byte_order = BYTE_ORDER_MARK;
  e.model = hash(HASH_START, guid, strlen(guid));
  e.size = m->block_size;
  e.checksum = hash(hash(HASH_START, &e, sizeof e), block, m->block_size);
  return e;
}

static snapshot *allocate(const flexhex_instance *m) {
  const size_t size = sizeof(snapshot) + m->block_size;
  void *memory =
      m->functions.allocateMemory ? m->functions.allocateMemory(1, size) : calloc(1, size);
  snapshot *s = (snapshot *)memory;
  if (s) {
    const snapshot head = {&FLEXHEX_MODEL, m->block_size, STATE_MAGIC, 0};
    *s = head;
  }
  return s;
}

/* The state when it is one of this FMU; NULL, with a message, when it is not. */
static snapshot *own(flexhex_instance *m, flexhex_call call, fmi2FMUstate state) {
  snapshot *s = (snapshot *)state;
  if (!s) {
    (void)flexhex_refuse(m, "%s: the state is NULL", flexhex_call_name(call));
    return NULL;
  }
  if (s->magic != STATE_MAGIC || s->model != &FLEXHEX_MODEL || s->size != m->block_size) {
    (void)flexhex_refuse(m, "%s: not a state of this FMU, or one that was freed",
                         flexhex_call_name(call));
    return NULL;
  }
  return s;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_GET_FMU_STATE);
  if (!m) {
    return fmi2Error;
  }
  if (!FMUstate) {
    return flexhex_refuse(m, "fmi2GetFMUstate: the pointer to the state is NULL");
  }
  snapshot *s = *FMUstate ? own(m, FLEXHEX_GET_FMU_STATE, *FMUstate) : allocate(m);
  if (!s) {
    return *FMUstate ? fmi2Error : flexhex_refuse(m, "fmi2GetFMUstate: out of memory");
  }
  memcpy(s + 1, m->head, m->block_size);
  *FMUstate = s;
  return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_SET_FMU_STATE);
  snapshot *s = m ? own(m, FLEXHEX_SET_FMU_STATE, FMUstate) : NULL;
  if (!s) {
    return fmi2Error;
  }
  memcpy(m->head, s + 1, m->block_size);
  return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_FREE_FMU_STATE);
  if (!m) {
    return fmi2Error;
  }
  if (!FMUstate || !*FMUstate) {
    return fmi2OK;
  }
  snapshot *s = own(m, FLEXHEX_FREE_FMU_STATE, *FMUstate);
  if (!s) {
    return fmi2Error;
  }
  s->magic = 0;
  if (m->functions.freeMemory) {
    m->functions.freeMemory(s);
  } else {
    free(s);
  }
  *FMUstate = NULL;
  return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_SERIALIZED_FMU_STATE_SIZE);
  if (!m || !own(m, FLEXHEX_SERIALIZED_FMU_STATE_SIZE, FMUstate)) {
    return fmi2Error;
  }
  if (!size) {
    return flexhex_refuse(m, "fmi2SerializedFMUstateSize: the pointer to the size is NULL");
  }
  *size = sizeof(envelope) + m->block_size;
  return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[],
                                 size_t size) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_SERIALIZE_FMU_STATE);
  snapshot *s = m ? own(m, FLEXHEX_SERIALIZE_FMU_STATE, FMUstate) : NULL;
  if (!s) {
    return fmi2Error;
  }
  const size_t needed = sizeof(envelope) + m->block_size;
  if (!serializedState || size < needed) {
    return flexhex_refuse(m, "fmi2SerializeFMUstate: room for %zu bytes, needs %zu",
                          serializedState ? size : 0, needed);
  }
  const envelope e = envelope_of(m, s + 1);
  memcpy(serializedState, &e, sizeof e);
  memcpy(serializedState + sizeof e, s + 1, m->block_size);
  return fmi2OK;
}

/* Why the bytes are no state of this FMU; NULL when they are one. */
static const char *objection(const flexhex_instance *m, const fmi2Byte bytes[], size_t size) {
  envelope e;
  if (!bytes || size < sizeof e) {
    return "too few bytes for a state";
  }
  memcpy(&e, bytes, sizeof e);
  if (memcmp(e.format, FORMAT, sizeof FORMAT) != 0) {
    return "not a serialised state of a flexhex FMU";
  }
  if (e.version != VERSION || e.byte_order != BYTE_ORDER_MARK) {
    return "written in another version or on another kind of machine";
  }
  if (e.model != hash(HASH_START, FLEXHEX_MODEL.guid, strlen(FLEXHEX_MODEL.guid))) {
    return "the state is of another FMU, or of another build of this one";
  }
  if (e.size != m->block_size || size != sizeof e + m->block_size) {
    return "bytes are missing or too many";
  }
  const envelope wanted = envelope_of(m, bytes + sizeof e);
  return memcmp(&e, &wanted, sizeof e) == 0 ? NULL : "the bytes are damaged (checksum)";
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
  flexhex_instance *m = flexhex_enter(c, FLEXHEX_DESERIALIZE_FMU_STATE);
  if (!m) {
    return fmi2Error;
  }
  if (!FMUstate) {
    return flexhex_refuse(m, "fmi2DeSerializeFMUstate: the pointer to the state is NULL");
  }
  const char *why = objection(m, serializedState, size);
  if (why) {
    return flexhex_refuse(m, "fmi2DeSerializeFMUstate: %s", why);
  }
  snapshot *s = allocate(m);
  if (!s) {
    return flexhex_refuse(m, "fmi2DeSerializeFMUstate: out of memory");
  }
  memcpy(s + 1, serializedState + sizeof(envelope), m->block_size);
  *FMUstate = s;
  return fmi2OK;
}
