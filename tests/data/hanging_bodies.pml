<?xml version="1.0" encoding="UTF-8"?>
<!-- A rigid plate; an elastic box that four springs hang from it; a box of springs that hangs from the elastic one. -->
<physicalModel name="hanging bodies">
<atoms>
<structuralComponent name="atoms">
<atom><atomProperties index="0" x="0" y="0" z="0"/></atom>
<atom><atomProperties index="1" x="10" y="0" z="0"/></atom>
<atom><atomProperties index="2" x="10" y="10" z="0"/></atom>
<atom><atomProperties index="3" x="0" y="10" z="0"/></atom>
<atom><atomProperties index="4" x="0" y="0" z="-15"/></atom>
<atom><atomProperties index="5" x="10" y="0" z="-15"/></atom>
<atom><atomProperties index="6" x="10" y="10" z="-15"/></atom>
<atom><atomProperties index="7" x="0" y="10" z="-15"/></atom>
<atom><atomProperties index="8" x="0" y="0" z="-5"/></atom>
<atom><atomProperties index="9" x="10" y="0" z="-5"/></atom>
<atom><atomProperties index="10" x="10" y="10" z="-5"/></atom>
<atom><atomProperties index="11" x="0" y="10" z="-5"/></atom>
<atom><atomProperties index="12" x="0" y="0" z="-30"/></atom>
<atom><atomProperties index="13" x="10" y="0" z="-30"/></atom>
<atom><atomProperties index="14" x="10" y="10" z="-30"/></atom>
<atom><atomProperties index="15" x="0" y="10" z="-30"/></atom>
<atom><atomProperties index="16" x="0" y="0" z="-20"/></atom>
<atom><atomProperties index="17" x="10" y="0" z="-20"/></atom>
<atom><atomProperties index="18" x="10" y="10" z="-20"/></atom>
<atom><atomProperties index="19" x="0" y="10" z="-20"/></atom>
</structuralComponent>
</atoms>
<exclusiveComponents>
<multiComponent name="bodies">
<structuralComponent name="plate" bodyType="rigid" mass="1">
<cell><cellProperties type="QUAD"/><atomRef index="0"/><atomRef index="1"/><atomRef index="2"/><atomRef index="3"/></cell>
</structuralComponent>
<structuralComponent name="tissue" bodyType="FEM" mass="1e-4" young="3000" poisson="0.45" collision="true">
<cell><cellProperties type="HEXAHEDRON"/><atomRef index="4"/><atomRef index="5"/><atomRef index="6"/><atomRef index="7"/><atomRef index="8"/><atomRef index="9"/><atomRef index="10"/><atomRef index="11"/></cell>
</structuralComponent>
<structuralComponent name="net" bodyType="stiffSpring" mass="2e-4" stiffness="20" damping="0.005">
<cell><cellProperties type="HEXAHEDRON"/><atomRef index="12"/><atomRef index="13"/><atomRef index="14"/><atomRef index="15"/><atomRef index="16"/><atomRef index="17"/><atomRef index="18"/><atomRef index="19"/></cell>
</structuralComponent>
<structuralComponent name="upper" bodyType="interaction" stiffness="8" body1="plate" body2="tissue">
<cell><cellProperties type="LINE"/><atomRef index="0"/><atomRef index="8"/></cell>
<cell><cellProperties type="LINE"/><atomRef index="1"/><atomRef index="9"/></cell>
<cell><cellProperties type="LINE"/><atomRef index="2"/><atomRef index="10"/></cell>
<cell><cellProperties type="LINE"/><atomRef index="3"/><atomRef index="11"/></cell>
</structuralComponent>
<structuralComponent name="lower" bodyType="interaction" stiffness="5" damping="0.001" body1="tissue" body2="net">
<cell><cellProperties type="LINE"/><atomRef index="4"/><atomRef index="16"/></cell>
<cell><cellProperties type="LINE"/><atomRef index="5"/><atomRef index="17"/></cell>
<cell><cellProperties type="LINE"/><atomRef index="6"/><atomRef index="18"/></cell>
<cell><cellProperties type="LINE"/><atomRef index="7"/><atomRef index="19"/></cell>
</structuralComponent>
</multiComponent>
</exclusiveComponents>
<informativeComponents/>
</physicalModel>
