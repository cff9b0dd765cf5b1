<?xml version="1.0" encoding="UTF-8"?>
<physicalModel name="block" nrOfAtoms="8" nrOfExclusiveComponents="1" nrOfInformativeComponents="6" nrOfCells="1">
<atoms>
<structuralComponent phymul="unnumbered">
<nrOfStructures value="8"/>
<atom>
<atomProperties index="0" x="0" y="0" z="0" mass="0.0010000000000000002" stiffness="1"/>
</atom>
<atom>
<atomProperties index="1" x="20" y="0" z="0" mass="0.0010000000000000002" stiffness="1"/>
</atom>
<atom>
<atomProperties index="2" x="0" y="20" z="0" mass="0.0010000000000000002" stiffness="1"/>
</atom>
<atom>
<atomProperties index="3" x="20" y="20" z="0" mass="0.0010000000000000002" stiffness="1"/>
</atom>
<atom>
<atomProperties index="4" x="0" y="0" z="20" mass="0.0010000000000000002" stiffness="1"/>
</atom>
<atom>
<atomProperties index="5" x="20" y="0" z="20" mass="0.0010000000000000002" stiffness="1"/>
</atom>
<atom>
<atomProperties index="6" x="0" y="20" z="20" mass="0.0010000000000000002" stiffness="1"/>
</atom>
<atom>
<atomProperties index="7" x="20" y="20" z="20" mass="0.0010000000000000002" stiffness="1"/>
</atom>
</structuralComponent>
</atoms>
<exclusiveComponents>
<multiComponent name="Exclusive Components">
<structuralComponent name="Elements" young="10000" poisson="0.3" density="1000">
<nrOfStructures value="1"/>
<cell>
<cellProperties type="HEXAHEDRON"/>
<nrOfStructures value="8"/>
<atomRef index="0"/>
<atomRef index="1"/>
<atomRef index="3"/>
<atomRef index="2"/>
<atomRef index="4"/>
<atomRef index="5"/>
<atomRef index="7"/>
<atomRef index="6"/>
</cell>
</structuralComponent>
</multiComponent>
</exclusiveComponents>
<informativeComponents>
<multiComponent name="Informative Components">
<structuralComponent name="x0">
<nrOfStructures value="4"/>
<atomRef index="0"/>
<atomRef index="2"/>
<atomRef index="4"/>
<atomRef index="6"/>
</structuralComponent>
<structuralComponent name="x1">
<nrOfStructures value="4"/>
<atomRef index="1"/>
<atomRef index="3"/>
<atomRef index="5"/>
<atomRef index="7"/>
</structuralComponent>
<structuralComponent name="y0">
<nrOfStructures value="4"/>
<atomRef index="0"/>
<atomRef index="1"/>
<atomRef index="4"/>
<atomRef index="5"/>
</structuralComponent>
<structuralComponent name="y1">
<nrOfStructures value="4"/>
<atomRef index="2"/>
<atomRef index="3"/>
<atomRef index="6"/>
<atomRef index="7"/>
</structuralComponent>
<structuralComponent name="z0">
<nrOfStructures value="4"/>
<atomRef index="0"/>
<atomRef index="1"/>
<atomRef index="2"/>
<atomRef index="3"/>
</structuralComponent>
<structuralComponent name="z1">
<nrOfStructures value="4"/>
<atomRef index="4"/>
<atomRef index="5"/>
<atomRef index="6"/>
<atomRef index="7"/>
</structuralComponent>
</multiComponent>
</informativeComponents>
</physicalModel>
