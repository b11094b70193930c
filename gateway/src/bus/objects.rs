//! Configures the drives: mode of operation, process data, watchdog.

use ethercrab::subdevice_group::{PreOp, PreOpPdi};
use ethercrab::{MainDevice, SubDevice, SubDeviceRef};

use super::exchange::Group;
use crate::config::{Config, Pdo, Role, Scale};

type Device<'a> = SubDeviceRef<'static, &'a SubDevice>;

const MODE: u16 = 0x6060;
const RATED_TORQUE: u16 = 0x6076;
const RX_ASSIGNED: u16 = 0x1c12;
const TX_ASSIGNED: u16 = 0x1c13;
const WATCHDOG_DIVIDER: u16 = 0x0400;
const WATCHDOG_PROCESS_DATA: u16 = 0x0420;
const DIVIDER_100_US: u16 = 2498; // 40 ns (2498 + 2)

/// Configure every drive in PRE-OP; errors name position and object.
pub async fn configure_drives(
    config: &Config,
    group: &Group<PreOp>,
    main: &'static MainDevice<'static>,
) -> Result<(), String> {
    for drive in &config.drive {
        let device = group
            .subdevice(main, usize::from(drive.position))
            .map_err(|why| format!("drive at position {}: {why:?}", drive.position))?;
        configure(config, &device)
            .await
            .map_err(|why| format!("drive at position {}: {why}", drive.position))?;
    }
    Ok(())
}

/// Compares the process data of every drive with the bytes out and in of the configuration.
pub fn check_mapping(
    group: &Group<PreOpPdi>,
    main: &'static MainDevice<'static>,
    bytes: (usize, usize),
) -> Result<(), String> {
    for device in group.iter(main) {
        let mapped = (device.outputs_raw().len(), device.inputs_raw().len());
        if mapped != bytes {
            return Err(format!(
                "{} at address {:#06x} maps {} bytes out and {} in, expected {} and {}: \
                 compare profile.rx and profile.tx with its objects 0x1C12 and 0x1C13",
                device.name(),
                device.configured_address(),
                mapped.0,
                mapped.1,
                bytes.0,
                bytes.1
            ));
        }
    }
    Ok(())
}

/// Configure one drive in PRE-OP; errors name the object.
async fn configure(config: &Config, device: &Device<'_>) -> Result<(), String> {
    let p = &config.profile;
    write(device, MODE, 0, p.mode).await?;
    let mode: i8 = read(device, MODE, 0).await?;
    if mode != p.mode {
        return Err(format!(
            "mode of operation 0x6060 is {mode}, expected {}: the drive may not support it",
            p.mode
        ));
    }
    if let Scale::RatedTorque { rated_torque, .. } = p.scale {
        let rated: u32 = read(device, RATED_TORQUE, 0).await?;
        let expected = (rated_torque * 1000.0).round();
        if f64::from(rated) != expected {
            return Err(format!(
                "rated torque 0x6076 is {rated} mN m, the configuration says {expected} mN m: \
                 set profile.scale.rated_torque.rated_torque_N_m or the drive"
            ));
        }
    }
    map(device, RX_ASSIGNED, &p.rx).await?;
    map(device, TX_ASSIGNED, &p.tx).await?;
    let ticks = config.bus.watchdog_ms as u16 * 10;
    for (register, value) in [(WATCHDOG_DIVIDER, DIVIDER_100_US), (WATCHDOG_PROCESS_DATA, ticks)] {
        device
            .register_write(register, value)
            .await
            .map_err(|why| format!("watchdog register {register:#06x}: {why:?}"))?;
    }
    let actual: u16 = device
        .register_read(WATCHDOG_PROCESS_DATA)
        .await
        .map_err(|why| format!("watchdog register 0x0420: {why:?}"))?;
    if actual != ticks {
        return Err(format!(
            "watchdog register 0x0420 is {actual}, expected {ticks}: the drive does not accept it"
        ));
    }
    Ok(())
}

/// Map and assign PDOs entry by entry: not every drive supports complete access.
async fn map(device: &Device<'_>, assigned: u16, pdos: &[Pdo]) -> Result<(), String> {
    write(device, assigned, 0, 0u8).await?;
    for pdo in pdos {
        write(device, pdo.index, 0, 0u8).await?;
        for (k, e) in (1u8..).zip(&pdo.entries) {
            let object = if e.role == Role::Gap { 0 } else { e.object };
            let value = u32::from(object) << 16 | u32::from(e.sub) << 8 | u32::from(e.bits);
            write(device, pdo.index, k, value).await?;
        }
        write(device, pdo.index, 0, pdo.entries.len() as u8).await?;
    }
    for (k, pdo) in (1u8..).zip(pdos) {
        write(device, assigned, k, pdo.index).await?;
    }
    write(device, assigned, 0, pdos.len() as u8).await
}

async fn write<T>(device: &Device<'_>, index: u16, sub: u8, value: T) -> Result<(), String>
where
    T: ethercrab::EtherCrabWireWrite,
{
    device
        .sdo_write(index, sub, value)
        .await
        .map_err(|why| format!("object {index:#06x}:{sub} cannot be written: {why:?}"))
}

async fn read<T>(device: &Device<'_>, index: u16, sub: u8) -> Result<T, String>
where
    T: ethercrab::EtherCrabWireReadSized,
{
    device
        .sdo_read(index, sub)
        .await
        .map_err(|why| format!("object {index:#06x}:{sub} cannot be read: {why:?}"))
}
