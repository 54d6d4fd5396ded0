//! What kernels for shadow rays leave out, read from the machine code that this test was linked with.
#![cfg(target_arch = "x86_64")]

use std::collections::{BTreeMap, BTreeSet};

use iced_x86::{
    Decoder, DecoderOptions, FlowControl, Instruction, InstructionInfoFactory, OpAccess, Register,
};
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SymbolKind};
use trisect_catalog::{Kernel, entries};
use trisect_method::{Form, Output};

/// Methods that divide when a ray is prepared, once for all triangles of a group: the shears of the
/// watertight test, and the direction by its longest part.
const DIVIDE_PER_RAY: [&str; 3] = ["watertight", "watertight-one-precision", "watertight-packet"];

/// Methods that cannot decide without a division.
const ALWAYS_DIVIDE: [&str; 1] = ["angle-sum"];

/// What it does not decide at once the exact method hands on, through memory, to stages that are compiled
/// apart; so it does with hits, for their values.
const HANDS_ON: &str = "exact";

/// A function of known name and place: by it the other addresses are found in the file.
#[inline(never)]
fn landmark() -> usize {
    landmark as *const () as usize
}

/// The machine code of this test.
struct Code {
    bytes: Vec<u8>,
    start: u64,
    /// Where each function ends, and its name, by where it begins.
    functions: BTreeMap<u64, (u64, String)>,
    /// What the system added to the addresses of the file.
    moved: u64,
}

impl Code {
    fn read() -> Self {
        let file = std::env::current_exe().and_then(std::fs::read).expect("a test can read itself");
        let object = object::File::parse(&*file).expect("it was linked on this system");
        let text = object.section_by_name(".text").expect("there is code");
        let functions: BTreeMap<u64, (u64, String)> = object
            .symbols()
            .filter(|symbol| symbol.kind() == SymbolKind::Text && symbol.size() > 0)
            .filter_map(|symbol| {
                let name = rustc_demangle::demangle(symbol.name().ok()?).to_string();
                Some((symbol.address(), (symbol.address() + symbol.size(), name)))
            })
            .collect();
        let place = functions.iter().find(|(_, (_, name))| name.contains("shadow_code::landmark"));
        let (address, _) = place.expect("the landmark is there");
        Self {
            bytes: text.data().expect("code is not compressed").to_vec(),
            start: text.address(),
            moved: landmark() as u64 - address,
            functions,
        }
    }

    /// The instructions of the function at an address.
    fn function(&self, address: u64) -> Vec<Instruction> {
        let (end, _) = self.functions.get(&address).expect("a function begins there");
        let offset = |address: u64| usize::try_from(address - self.start).expect("it is in memory");
        let bytes = &self.bytes[offset(address)..offset(*end)];
        Decoder::with_ip(64, bytes, address, DecoderOptions::NONE).into_iter().collect()
    }

    /// A kernel's function and those that it calls for its instruction set, which are compiled apart.
    fn kernel(&self, kernel: &Kernel) -> Vec<Vec<Instruction>> {
        let mut known = BTreeSet::new();
        let mut next = vec![kernel.address() as u64 - self.moved];
        let mut functions = Vec::new();
        while let Some(address) = next.pop() {
            if !known.insert(address) {
                continue;
            }
            let function = self.function(address);
            let targets =
                function.iter().filter(|i| is_jump(i)).map(Instruction::near_branch_target);
            next.extend(targets.filter(|target| {
                self.functions.get(target).is_some_and(|(_, name)| name.contains("vectorize"))
            }));
            functions.push(function);
        }
        functions
    }
}

fn is_jump(instruction: &Instruction) -> bool {
    matches!(
        instruction.flow_control(),
        FlowControl::UnconditionalBranch | FlowControl::ConditionalBranch | FlowControl::Call
    ) && instruction.near_branch_target() != 0
}

/// The loops that hold no other loop: those over triangles.
fn innermost_loops(function: &[Instruction]) -> Vec<&[Instruction]> {
    let mut ends: BTreeMap<usize, usize> = BTreeMap::new();
    for (place, instruction) in function.iter().enumerate() {
        if is_jump(instruction) && instruction.flow_control() != FlowControl::Call {
            let head = function.partition_point(|i| i.ip() < instruction.near_branch_target());
            if head <= place && function[head].ip() == instruction.near_branch_target() {
                let end = ends.entry(head).or_default();
                *end = place.max(*end);
            }
        }
    }
    let holds_none = |(head, end): (&usize, &usize)| {
        ends.range(head + 1..=*end).next().is_none().then_some(&function[*head..=*end])
    };
    ends.iter().filter_map(holds_none).collect()
}

/// Whether it divides, takes a root or estimates a reciprocal.
fn divides(instruction: &Instruction) -> bool {
    let name = format!("{:?}", instruction.mnemonic()).to_lowercase();
    let name = name.trim_start_matches('v');
    ["div", "idiv", "rcp", "rsqrt", "sqrt"].iter().any(|start| name.starts_with(start))
}

/// Whether it writes to memory that is not the function's own stack.
fn stores(instruction: &Instruction) -> bool {
    let mut factory = InstructionInfoFactory::new();
    factory.info(instruction).used_memory().iter().any(|memory| {
        let writes = !matches!(
            memory.access(),
            OpAccess::None | OpAccess::Read | OpAccess::CondRead | OpAccess::NoMemAccess
        );
        writes && !matches!(memory.base(), Register::RSP | Register::RBP)
    })
}

/// Kernels of single precision that are asked for `output`.
fn kernels(
    output: Output,
    division: Form,
) -> impl Iterator<Item = (&'static str, &'static Kernel)> {
    entries().iter().flat_map(move |entry| {
        let asked = entry.f32.timed.iter().filter(move |kernel| kernel.variant.needs == output);
        let asked = asked.filter(move |kernel| kernel.variant.division == division);
        asked.map(|kernel| (entry.info.name, kernel))
    })
}

#[test]
fn shadow_rays_are_decided_without_a_division() {
    let code = Code::read();
    let (mut decided, mut per_ray) = (BTreeSet::new(), BTreeSet::new());
    for (method, kernel) in kernels(Output::Occlusion, Form::Deferred) {
        decided.insert(method);
        let place = format!("{:?}", kernel.variant);
        let functions = code.kernel(kernel);
        if functions.iter().flatten().any(divides) {
            per_ray.insert(method);
        }
        let loops: Vec<_> = functions.iter().flat_map(|f| innermost_loops(f)).collect();
        let tested = loops.iter().any(|body| body.len() > 20);
        assert!(tested, "{place}: no loop over triangles was found");
        for instruction in loops.into_iter().flatten() {
            let at = format!("{place}: {:?} at {:x}", instruction.code(), instruction.ip());
            assert!(!divides(instruction), "divides for each triangle: {at}");
            let may_store = method == HANDS_ON;
            assert!(may_store || !stores(instruction), "stores something for each triangle: {at}");
        }
    }
    let all = entries().iter().map(|entry| entry.info.name);
    let missing: Vec<&str> = all.filter(|name| !decided.contains(name)).collect();
    assert_eq!(missing, ALWAYS_DIVIDE, "methods without a kernel that decides by numerators");
    assert_eq!(per_ray, BTreeSet::from(DIVIDE_PER_RAY), "methods that divide for each ray");
}

/// That divisions are found where there are some: whoever asks for values gets one, mostly in the loop
/// itself; the compiler may put it behind a branch of its own that leaves the loop and comes back.
#[test]
fn values_take_a_division() {
    let code = Code::read();
    let (mut in_loops, mut all) = (0, 0);
    let computed_here = |(method, _): &(&str, _)| *method != HANDS_ON;
    for (_, kernel) in kernels(Output::Barycentrics, Form::Deferred).filter(computed_here) {
        let functions = code.kernel(kernel);
        let place = format!("{:?}", kernel.variant);
        assert!(functions.iter().flatten().any(divides), "{place} divides nowhere");
        let mut loops = functions.iter().flat_map(|f| innermost_loops(f)).flatten();
        in_loops += usize::from(loops.any(divides));
        all += 1;
    }
    assert!(all > 100 && 2 * in_loops > all, "{in_loops} of {all} kernels divide in their loop");
}
