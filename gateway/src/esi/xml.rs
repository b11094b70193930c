//! The devices of an ESI file.

use roxmltree::{Document, Node};

/// One device of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Device {
    pub name: String,
    pub vendor_id: u32,
    pub product_code: u32,
    pub revision: u32,
    /// To the drive, and from it.
    pub rx: Vec<PdoMap>,
    pub tx: Vec<PdoMap>,
    pub startup: Vec<InitCmd>,
}

/// An object that the maker wants to be written on the way to operation.
#[derive(Clone, Debug, PartialEq)]
pub struct InitCmd {
    pub object: u16,
    pub sub: u8,
    /// In the order of the bus: the lowest byte first.
    pub data: Vec<u8>,
    pub comment: String,
}

/// A PDO with its entries.
#[derive(Clone, Debug, PartialEq)]
pub struct PdoMap {
    pub index: u16,
    /// The file gives it a sync manager: it is exchanged unless something else is configured.
    pub assigned: bool,
    /// Its entries cannot be changed.
    pub fixed: bool,
    pub entries: Vec<Object>,
}

/// An entry of a PDO; object 0 is a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    pub object: u16,
    pub sub: u8,
    pub bits: u8,
    pub name: String,
}

/// Every device of the text of an ESI file, or what is wrong with it.
pub fn devices(text: &str) -> Result<Vec<Device>, String> {
    let document = Document::parse(text).map_err(|why| format!("no XML: {why}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "EtherCATInfo" {
        let name = root.tag_name().name();
        return Err(format!("no ESI file: its root is <{name}>, expected <EtherCATInfo>"));
    }
    let vendor = child(root, "Vendor").ok_or("no <Vendor>")?;
    let vendor_id = number(vendor, "Id")?;
    let list = child(root, "Descriptions").and_then(|d| child(d, "Devices"));
    let list = list.ok_or("no <Descriptions> with <Devices>")?;
    let found: Vec<_> = children(list, "Device").map(|d| device(d, vendor_id)).collect();
    let found = found.into_iter().collect::<Result<Vec<_>, _>>()?;
    if found.is_empty() {
        return Err("no <Device>".to_owned());
    }
    Ok(found)
}

fn device(node: Node, vendor_id: u32) -> Result<Device, String> {
    let kind = child(node, "Type").ok_or("a <Device> without <Type>")?;
    let name = kind.text().unwrap_or("").trim().to_owned();
    let at = |why: String| format!("device {name:?}: {why}");
    let attribute = |key: &str| {
        let text = kind.attribute(key).ok_or_else(|| format!("<Type> without {key}"))?;
        parse(text).ok_or_else(|| format!("{key}={text:?} is no number"))
    };
    let maps = |tag: &str| children(node, tag).map(pdo).collect::<Result<Vec<_>, _>>();
    Ok(Device {
        vendor_id,
        product_code: attribute("ProductCode").map_err(at)?,
        revision: attribute("RevisionNo").map_err(at)?,
        rx: maps("RxPdo").map_err(at)?,
        tx: maps("TxPdo").map_err(at)?,
        startup: startup(node).map_err(at)?,
        name: name.clone(),
    })
}

/// `Mailbox/CoE/InitCmd`.
fn startup(device: Node) -> Result<Vec<InitCmd>, String> {
    let coe = child(device, "Mailbox").and_then(|mailbox| child(mailbox, "CoE"));
    let list = coe.into_iter().flat_map(|coe| children(coe, "InitCmd"));
    list.map(|node| init_cmd(node).map_err(|why| format!("<InitCmd>: {why}"))).collect()
}

fn init_cmd(node: Node) -> Result<InitCmd, String> {
    let text =
        |name: &str| child(node, name).and_then(|n| n.text()).unwrap_or("").trim().to_owned();
    let sub = number(node, "SubIndex")?;
    Ok(InitCmd {
        object: small(number(node, "Index")?)?,
        sub: u8::try_from(sub).map_err(|_| format!("{sub} is above 255"))?,
        data: bytes(&text("Data"))
            .ok_or_else(|| format!("<Data> {:?} is no bytes", text("Data")))?,
        comment: text("Comment"),
    })
}

/// Bytes written as hexadecimal digits.
fn bytes(text: &str) -> Option<Vec<u8>> {
    let even = text.is_ascii() && text.len().is_multiple_of(2);
    let pairs = (0..text.len() / 2).map(|k| u8::from_str_radix(&text[2 * k..2 * k + 2], 16).ok());
    even.then(|| pairs.collect()).flatten()
}

fn pdo(node: Node) -> Result<PdoMap, String> {
    let index = small(number(node, "Index")?)?;
    let at = |why: String| format!("PDO {index:#06x}: {why}");
    let entries = children(node, "Entry").map(entry).collect::<Result<Vec<_>, _>>().map_err(at)?;
    let set = |key: &str| node.attribute(key).is_some_and(|v| v == "1" || v == "true");
    Ok(PdoMap { index, assigned: node.has_attribute("Sm"), fixed: set("Fixed"), entries })
}

fn entry(node: Node) -> Result<Object, String> {
    let object = small(number(node, "Index")?)?;
    let sub = if child(node, "SubIndex").is_some() { number(node, "SubIndex")? } else { 0 };
    let bits = number(node, "BitLen")?;
    let within = |value: u32| u8::try_from(value).map_err(|_| format!("{value} is above 255"));
    let name = child(node, "Name").and_then(|n| n.text()).unwrap_or("").trim().to_owned();
    Ok(Object { object, sub: within(sub)?, bits: within(bits)?, name })
}

fn child<'a>(node: Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    node.children().find(|c| c.tag_name().name() == name)
}

fn children<'a>(node: Node<'a, 'a>, name: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |c| c.tag_name().name() == name)
}

fn number(node: Node, name: &str) -> Result<u32, String> {
    let found = child(node, name).ok_or_else(|| {
        let tag = node.tag_name().name();
        format!("<{tag}> without <{name}>")
    })?;
    let text = found.text().unwrap_or("");
    parse(text).ok_or_else(|| format!("<{name}> {text:?} is no number"))
}

/// `#x1A00`, `0x1A00` or decimal.
fn parse(text: &str) -> Option<u32> {
    let text = text.trim();
    let hex = text.strip_prefix("#x").or_else(|| text.strip_prefix("0x"));
    hex.map_or_else(|| text.parse().ok(), |digits| u32::from_str_radix(digits, 16).ok())
}

fn small(value: u32) -> Result<u16, String> {
    u16::try_from(value).map_err(|_| format!("index {value:#x} is above 0xffff"))
}
